"""`Finding`: something about an agent that its plays or its answers to observations show."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from atari.learning.diagnosis.plays import Play, Plays

FindingKind = Literal["delayed actions", "unused action", "random from", "loop", "side not visited", "unseen object"]

RESTARTS = "--restart-share 0.25 --restart-from frontier.states"
_LESS = ("--epsilon 0.001", "--action-delay 0")
"""The options that help by a smaller value. Of the other numbers, a larger one does."""


@dataclass(frozen=True)
class Finding:
    """Something about an agent that keeps it from playing better.

    Attributes:
        kind: what it is.
        place: where it is: the name of a press ("LEFT"), an object ("ball"), a side ("left"), a delay ("3 steps"), or
            where something begins ("250 points", "step 400").
        number: the delay, or the score or step at which something begins; None for names.
        share: the part of the steps, games or range that is concerned, 0..1.
        text: one sentence with the numbers.
        options: options of `atari train` to try, the cheapest first.

    Example:
        >>> from atari.learning.diagnosis.findings import Finding
        >>> print(Finding("unused action", "FIRE", None, 1.0, "The agent never presses FIRE."))
        The agent never presses FIRE.
    """

    kind: FindingKind
    place: str
    number: int | None
    share: float
    text: str
    options: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.text


def percent(part: float) -> str:
    """A part in percent; only all is 100 %, and only none is 0 %."""
    if 0 < part < 0.01:
        return "less than 1 %"
    return f"{min(99, round(100 * part)) if part < 1 else 100} %"


def is_new(option: str, training: Mapping[str, Any]) -> bool:
    """Whether the agent of a training takes an option of `atari train`, and the training did without it.

    Args:
        option: one flag or more with their values.
        training: the fields of the task and the options of the training, as in its configuration.

    Example:
        >>> from atari.learning.diagnosis.findings import is_new
        >>> is_new("--gamma 0.997", {"gamma": 0.99}), is_new("--gamma 0.997", {"gamma": 0.999})
        (True, False)
    """
    words = option.replace("--sticky", "--repeat-action-probability").split()
    given = {flag[2:].replace("-", "_"): value for flag, value in zip(words[::2], words[1::2], strict=True)}
    if not given.keys() <= training.keys() or ("epsilon" in given and training.get("lane_epsilon") is not None):
        return False
    return not all(_has(training[name], value, option in _LESS) for name, value in given.items())


def _has(had: Any, value: str, less: bool) -> bool:
    """Whether a training's value is that of an option, or beyond it."""
    if not isinstance(had, (int, float)):
        return str(had) == value
    return had <= float(value) if less else had >= float(value)


class Step(NamedTuple):
    """A step of a game; the state is that after the step."""

    play: int
    step: int


def spread(plays: Plays, count: int, seed: int) -> list[Step]:
    """Some steps of play, at most `count`, drawn from all steps alike but the first and last ones of games."""
    steps = [Step(number, step) for number, play in enumerate(plays) for step in range(8, len(play) - 8)]
    if len(steps) <= count:
        return steps
    chosen = np.random.default_rng(seed).choice(len(steps), count, replace=False)
    return [steps[index] for index in sorted(chosen.tolist())]


def losses(play: Play) -> npt.NDArray[np.int64]:
    """The steps that lose a life; in a game without lives, those with a reward."""
    lost = np.flatnonzero(play.lives < play.lives_before)
    return lost if play.first_lives > 1 or len(lost) else np.flatnonzero(play.rewards != 0)


def scores_before(play: Play) -> npt.NDArray[np.int64]:
    """The score of the game before each step, (T,) int64."""
    return play.totals - play.rewards
