"""The table of a sweep while it runs: in a terminal it changes in place, elsewhere each change is a line."""

import math
import time
from collections.abc import Sequence
from typing import TextIO

from atari.base.json_text import escaped
from atari.base.text_table import aligned
from atari.learning.sweep.processes import Progress

_SECONDS = 1.0
"""Seconds between two changes of the table in a terminal."""


class Table:
    """Shows the progress of runs on a stream.

    Args:
        stream: the stream. A terminal shows all runs that fit, first those that are at work or have failed.
        width, height: the columns and lines of the terminal.
    """

    def __init__(self, stream: TextIO, width: int, height: int) -> None:
        self._stream, self._width, self._height = stream, max(20, width - 1), max(1, height - 3)
        self._drawn, self._next = 0, 0.0
        self._states: dict[str, str] = {}

    def show(self, runs: Sequence[Progress]) -> None:
        """Show the present progress."""
        changed = [one for one in runs if self._states.get(one.run.name, "waiting") != one.state]
        self._states = {one.run.name: one.state for one in runs}
        if not self._stream.isatty():
            for one in changed:
                self._stream.write(f"{' '.join(' '.join(map(str, cells(one))).split())}\n")
            self._stream.flush()
        elif changed or time.monotonic() >= self._next:
            self._next = time.monotonic() + _SECONDS
            lines = self._lines(runs)
            self._stream.write(f"\x1b[{self._drawn}F\x1b[J" if self._drawn else "")
            self._stream.write("".join(f"{_within(line, self._width)}\n" for line in lines))
            self._stream.flush()
            self._drawn = len(lines)

    def _lines(self, runs: Sequence[Progress]) -> list[str]:
        """The lines of the table: one for each run, or for as many as there are lines."""
        order = {"waiting": 2, "done": 1}
        shown = runs if len(runs) <= self._height else sorted(runs, key=lambda one: order.get(one.state, 0))
        lines = aligned([HEAD, *(cells(one) for one in shown[: self._height])], bool)
        states = [one.state for one in runs]
        counts = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
        return [*lines, f"{len(runs)} runs: {counts}"]


def _within(line: str, width: int) -> str:
    """The line; if it is wider than the terminal, the whole words that fit."""
    return line if len(line) <= width else f"{line[: width - 1].rpartition(' ')[0].rstrip()} …"


HEAD = ("run", "state", "steps", "of", "score")


def cells(one: Progress) -> tuple[str, ...]:
    """The cells of a run: name, state, steps, all steps, and the mean score of the last whole games."""
    row = one.row
    score = row.get("score", math.nan)
    error = escaped(f": {one.error}" if one.error else "")
    return (
        one.run.name,
        f"{one.state}{error}",
        f"{row.get('step', 0):,.0f}",
        f"{one.run.options.total_steps:,}",
        "-" if math.isnan(score) else f"{score:,.1f}",
    )
