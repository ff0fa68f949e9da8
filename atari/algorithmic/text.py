"""How an algorithmic task is shown: the input with its read head, what was written, and what should have been.

The labels and colours are those of OpenAI Gym, whose pictures are in many courses.
"""

from typing import TYPE_CHECKING

from gymnasium.utils import colorize

if TYPE_CHECKING:
    from atari.algorithmic.environment import AlgorithmicEnv

MARGIN = 2
"""How many blanks are shown on either side of the input."""


def show(env: "AlgorithmicEnv") -> str:
    """The present state of an environment as lines of text, with colours for a terminal."""
    title = f"Total length of input instance: {len(env.rows[0])}, step: {env.time}"
    return "\n".join([title, "=" * len(title), *_input(env), *_output(env), "", *_last_step(env)]) + "\n"


def _input(env: "AlgorithmicEnv") -> list[str]:
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


def _output(env: "AlgorithmicEnv") -> list[str]:
    written = env.spell(env.target[: env.write_head])
    if env.action is not None and env.action[1]:
        character = env.action[2]
        color = "green" if character == env.target[env.write_head - 1] else "red"
        written = written[:-1] + colorize(env.spell([character]), color, highlight=True)
    margin = " " * MARGIN
    return [_line("Output Tape", margin + written), _line("Targets", margin + env.spell(env.target))]


def _last_step(env: "AlgorithmicEnv") -> list[str]:
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
