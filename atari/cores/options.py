"""What every core is made with, checked at the door.

What is called `check` raises a TypeError for what is of the wrong kind and a ValueError for what is out of range, with
a sentence that says what is expected.
"""

import math
import operator
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from atari.game import Game

SEED_LIMIT = 2**32
_FRAMES_LIMIT = 2**31


@dataclass(frozen=True)
class CoreOptions:
    """The options of a core, after checking."""

    repeat_action_probability: float = 0.25
    mode: int | None = None
    difficulty: int | None = None
    frame_skip: int = 1
    max_num_frames_per_episode: int = 0
    sound: bool = False
    color_averaging: bool = False

    @classmethod
    def check(cls, game: Game, **options: Any) -> "CoreOptions":
        """Check options given by a user against what `game` offers."""
        probability = options["repeat_action_probability"]
        checked = cls(
            repeat_action_probability=check_probability("repeat_action_probability", probability),
            mode=_check_choice("mode", options["mode"], game.modes, game),
            difficulty=_check_choice("difficulty", options["difficulty"], game.difficulties, game),
            frame_skip=check_integer("frame_skip", options["frame_skip"], 1, 10_000),
            max_num_frames_per_episode=check_integer(
                "max_num_frames_per_episode", options["max_num_frames_per_episode"], 0, _FRAMES_LIMIT - 1
            ),
            sound=bool(options["sound"]),
            color_averaging=bool(options["color_averaging"]),
        )
        if game.rules is not None and game.rules.selection_frames:
            _check_selection(game, game.rules.selection_frames, checked)
        return checked


def check_integer(name: str, value: Any, low: int, high: int) -> int:
    """`value` as an int within low..high; bools are refused, NumPy integers accepted."""
    try:
        number = operator.index(value)
    except TypeError:
        number = None
    if number is None or isinstance(value, bool):
        raise TypeError(f"{name} must be an integer within {low}..{high}, got {value!r}")
    if not low <= number <= high:
        raise ValueError(f"{name} must be within {low}..{high}, got {number}")
    return number


def check_probability(name: str, value: Any) -> float:
    """`value` as a float within 0..1."""
    try:
        number = math.nan if isinstance(value, (bool, str)) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if math.isnan(number):
        raise TypeError(f"{name} must be a number within 0..1, got {value!r}")
    if not 0.0 <= number <= 1.0:
        raise ValueError(f"{name} must be within 0..1, got {number}")
    return number


def check_name(name: str, value: Any, choices: Iterable[str]) -> str:
    """`value` as one of the names that there are."""
    choices = tuple(choices)
    if value not in choices:
        raise ValueError(f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}")
    return str(value)


def check_action(action: Any) -> int:
    """`action` as an ALE action number 0..17."""
    try:
        number = operator.index(action)
    except TypeError:
        raise TypeError(f"an action is an integer 0..17, got {action!r}") from None
    if not 0 <= number <= 17:
        raise ValueError(f"an ALE action number is within 0..17, got {number}")
    return number


def check_strength(strength: Any) -> float:
    """`strength` as a finite float that cannot overflow a paddle's position."""
    try:
        number = None if isinstance(strength, str) else float(strength)
    except (TypeError, ValueError):
        number = None
    if number is None:
        raise TypeError(f"strength must be a number, got {strength!r}")
    if not abs(number) <= 1000.0:  # written so that NaN fails too
        raise ValueError(f"strength must be finite and at most 1000 in magnitude, got {number}")
    return number


def check_poke(index: Any, value: Any) -> tuple[int, int]:
    """The arguments of `set_ram` as two ints."""
    return check_integer("index", index, 0, 127), check_integer("value", value, 0, 255)


def _check_selection(game: Game, frames: int, options: CoreOptions) -> None:
    """Refuse options with which a reset that selects the mode by playing would go on for ever.

    The bounds are where ale-py always came to an end in thousands of resets.
    """
    because = f"{game.id} selects its mode at reset by playing, which may never end with"
    if options.repeat_action_probability > 0.7:
        raise ValueError(f"{because} repeat_action_probability above 0.7, got {options.repeat_action_probability}")
    if options.frame_skip > 4:
        raise ValueError(f"{because} frame_skip above 4, got {options.frame_skip}")
    needed, limit = frames * options.frame_skip, options.max_num_frames_per_episode
    if 0 < limit < needed:
        raise ValueError(f"{because} max_num_frames_per_episode below {needed}, got {limit}")


def _check_choice(name: str, value: Any, choices: tuple[int, ...], game: Game) -> int | None:
    if value is None:
        return None
    try:
        number = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be an integer or None, got {value!r}") from None
    if number not in choices:
        raise ValueError(f"{game.id} has no {name} {number}; it has {', '.join(map(str, choices))}")
    return number
