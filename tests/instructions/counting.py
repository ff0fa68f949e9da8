"""Counts the instructions of the native core for a frame, and compares them with recorded counts.

Valgrind counts what the program `play` (play.cpp) executes for a short game and for a longer one; the difference,
divided by the difference in frames, is the count of a frame, without start and reset. Unlike a time, it is the same on
every run and on a busy machine, so a change of a few percent is visible. It depends on the compiler and the processor's
architecture, so counts are compared only with those recorded for the same ones.

`scripts/count-instructions` builds `play` and runs this file.
"""

import argparse
import json
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import atari

sys.path.insert(0, str(Path(__file__).parent))
from game_words import game_words

RECORD = Path(__file__).parent / "counts.json"
GAMES = ("breakout", "pong", "seaquest", "enduro", "ms_pacman", "pitfall2", "freeway", "tetris")
FIGURES = {"act": "nothing", "act, screen_rgb": "rgb"}
"""The figures that are counted, and their names for `play`."""
SHORT, LONG = 60, 300
"""Frames of the two runs."""
ALLOWED = 0.03
"""A count may rise by this part of the recorded one."""

Counts = dict[str, dict[str, int]]
"""Instructions a frame by game and figure."""


def instructions_in(output: str) -> int:
    """The total in the output or in a file of callgrind.

    Raises:
        ValueError: there is none.
    """
    total = re.search(r"^(?:summary|totals): (\d+)", output, re.MULTILINE)
    if total is None:
        raise ValueError(f"callgrind's output has no total of instructions:\n{output[-500:]}")
    return int(total[1])


def count(folder: Path, game_id: str, figure: str) -> int:
    """Instructions a frame. Callgrind's files stay in `folder`, for callgrind_annotate."""
    game = folder / f"{game_id}.game"
    game.write_text(game_words(atari.games.find(game_id)))
    totals = []
    for frames in (SHORT, LONG):
        out = folder / f"callgrind.{game_id}.{FIGURES[figure]}.{frames}"
        play = [str(folder / "play"), str(game), str(frames), FIGURES[figure]]
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", *play]
        done = subprocess.run(command, text=True, capture_output=True)
        if done.returncode != 0:
            raise RuntimeError(f"{game_id} could not be counted: valgrind says\n{done.stderr}")
        totals.append(instructions_in(out.read_text()))
    return round((totals[1] - totals[0]) / (LONG - SHORT))


def count_all(folder: Path, games: list[str]) -> Counts:
    """All figures of these games. One process a core: counts do not depend on what else runs."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {game: {figure: pool.submit(count, folder, game, figure) for figure in FIGURES} for game in games}
        return {game: {figure: job.result() for figure, job in figures.items()} for game, figures in jobs.items()}


def changes(recorded: Counts, now: Counts) -> dict[tuple[str, str], float]:
    """The rise of each recorded count (0.03: three percent), by game and figure."""
    return {
        (game, figure): value / recorded[game][figure] - 1
        for game, figures in now.items()
        for figure, value in figures.items()
        if figure in recorded.get(game, {})
    }


def table(recorded: Counts, now: Counts) -> str:
    """A table of thousands of instructions a frame: the recorded count, the new one, and the change."""
    width = max(map(len, now))
    risen = changes(recorded, now)
    lines = ["thousands of instructions a frame", " " * width]
    for figure in FIGURES:
        lines[1] += f"  {figure + ': recorded':>24}{'now':>9}  change"
    for game, figures in now.items():
        cells = []
        for figure, value in figures.items():
            before, change = "-", "-"
            if (game, figure) in risen:
                before, change = f"{recorded[game][figure] / 1000:.1f}", f"{risen[game, figure]:+.1%}"
            cells.append(f"{before:>24}{value / 1000:>9.1f}{change:>8}")
        lines.append(f"{game:{width}}  " + "  ".join(cells))
    return "\n".join(lines)


def verdict(record: dict[str, Any], build: dict[str, str], now: Counts) -> tuple[list[str], bool]:
    """A report on the counts, one line each, and whether they are acceptable."""
    of_record, of_build = (f"{what.get('compiler')} on {what.get('architecture')}" for what in (record, build))
    if of_record != of_build:
        return [f"Not compared: the recorded counts are of {of_record}, this build is of {of_build}."], True
    risen = changes(record["instructions"], now)
    too_many = [f"{game} ({figure})" for (game, figure), change in risen.items() if change > ALLOWED]
    fewer = [f"{game} ({figure})" for (game, figure), change in risen.items() if change < -ALLOWED]
    unknown = [game for game in now if game not in record["instructions"]]
    lines = []
    if too_many:
        lines.append(f"Risen by more than {ALLOWED:.0%}: {', '.join(too_many)}.")
    if fewer:
        lines.append(f"Fallen by more than {ALLOWED:.0%}: {', '.join(fewer)}; --record keeps what was won.")
    if unknown:
        lines.append(f"Not recorded: {', '.join(unknown)}.")
    return lines or [f"No count has changed by more than {ALLOWED:.0%}."], not too_many


def main() -> int:
    """Count, then compare or record."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where `play` and build.json are")
    parser.add_argument("--games", nargs="+", default=list(GAMES), metavar="GAME")
    parser.add_argument("--record", action="store_true", help="write counts.json instead of comparing with it")
    options = parser.parse_args()
    build = json.loads((options.folder / "build.json").read_text())
    record = json.loads(RECORD.read_text()) if RECORD.exists() else {"instructions": {}}
    now = count_all(options.folder, options.games)
    print(table(record["instructions"], now))
    if options.record:
        RECORD.write_text(json.dumps({**build, "instructions": now}, indent=1) + "\n")
        print(f"Recorded in {RECORD.name}: {build['compiler']} on {build['architecture']}.")
        return 0
    lines, acceptable = verdict(record, build, now)
    print("\n".join(lines))
    return 0 if acceptable else 1


if __name__ == "__main__":
    sys.exit(main())
