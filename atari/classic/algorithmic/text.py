"""Renders an algorithmic task as text: the input with its read head, the output, and the target.

The labels and colours are those of OpenAI Gym, whose screenshots are in many courses.
"""

from typing import Protocol

from gymnasium.utils import colorize

MARGIN = 2
"""Blanks on either side of the input."""


class Task(Protocol):
    """The state that `show` reads; `AlgorithmicEnv` has it and documents it."""

    height: int
    rows: list[list[int]]
    target: list[int]
    read_head: tuple[int, int]
    write_head: int
    time: int
    action: tuple[int, int, int] | None
    reward: float
    total_reward: float

    @property
    def moves(self) -> tuple[str, ...]:
        """The names of the movements."""

    def read(self, column: int, row: int) -> int:
        """The character at a position of the input."""

    def spell(self, characters: list[int]) -> str:
        """Characters as text."""


def show(env: Task) -> str:
    """The state of an environment as lines of text, with colours for a terminal."""
    title = f"Total length of input instance: {len(env.rows[0])}, step: {env.time}"
    return "\n".join([title, "=" * len(title), *_input(env), *_output(env), "", *_last_step(env)]) + "\n"


def _input(env: Task) -> list[str]:
    label = "Observation Tape" if env.height == 1 else "Observation Grid"
    above = 0 if env.height == 1 else 1
    lines: list[str] = []
    for row in range(-above, env.height + above):
        places = [(column, row) for column in range(-MARGIN, len(env.rows[0]) + MARGIN)]
        cells = [env.spell([env.read(*place)]) for place in places]
        if env.read_head in places:
            head = places.index(env.read_head)
            cells[head] = colorize(cells[head], "green", highlight=True)
        lines.append(_line("" if lines else label, "".join(cells)))
    return lines


def _output(env: Task) -> list[str]:
    written = env.spell(env.target[: env.write_head])
    if env.action is not None and env.action[1]:
        character = env.action[2]
        color = "green" if character == env.target[env.write_head - 1] else "red"
        written = written[:-1] + colorize(env.spell([character]), color, highlight=True)
    margin = " " * MARGIN
    return [_line("Output Tape", margin + written), _line("Targets", margin + env.spell(env.target))]


def _last_step(env: Task) -> list[str]:
    if env.action is None:
        return []
    move, write, character = env.action
    return [
        _line("Current reward", f"{env.reward:.3f}"),
        _line("Cumulative reward", f"{env.total_reward:.3f}"),
        _line("Action", f"Tuple(move over input: {env.moves[move]},"),
        _line("", f"      write to the output tape: {bool(write)},"),
        _line("", f"      prediction: {env.spell([character])})"),
    ]


def _line(label: str, content: str) -> str:
    return f"{label:<20}: {content}" if label else " " * 22 + content
