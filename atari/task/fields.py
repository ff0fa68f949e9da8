"""The fields of a `Task` one by one: the values that each accepts, and its group."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from atari.actions import PLAYER_ACTIONS, Action
from atari.games.frozen import FrozenDict
from atari.games.rewards import as_one_line
from atari.validation import (
    MOST_FRAMES_SKIPPED,
    OptionTypeError,
    check_frameskip,
    check_integer,
    check_name,
    check_probability,
)

ObsType = Literal["rgb", "grayscale", "ram", "dict", "rgb_dict"]
Fire = Literal["never", "before_noops", "after_noops"]
OnReset = Literal["noop", "continue", "new_game"]
Unit = Literal["frame", "skip"]
Seeding = Literal["gymnasium", "ale"]
Padding = Literal["zero", "reset"]
EndFrames = Literal["last", "gymnasium", "baselines", "envpool"]

NO_LIMIT = 2**31 - 1
"""The highest limit of frames or steps."""


class _Unset:
    """The type of `UNSET`."""

    def __repr__(self) -> str:
        return "as the game says"


UNSET: Any = _Unset()
"""The default of an option that a user may leave out."""

GROUPS: Mapping[str, tuple[str, ...]] = FrozenDict(
    {
        "game": ("game", "rules", "rom_md5", "mode", "difficulty", "players"),
        "play": (
            "actions",
            "continuous",
            "continuous_action_threshold",
            "repeat_action_probability",
            "frameskip",
            "interventions",
        ),
        "begin": ("noops", "fire", "fire_counts", "third_action", "fire_unit", "fire_again", "seeding"),
        "lives": ("episodic_life", "lives_unit", "on_reset", "last_life", "seamless_lives", "life_loss_info"),
        "limits": ("max_num_frames_per_episode", "max_frames", "max_episode_steps"),
        "observation": (
            "obs_type",
            "img_height",
            "img_width",
            "stack_num",
            "maxpool",
            "pool_rgb",
            "padding",
            "end_frames",
            "sound_obs",
            "agent_indicator",
        ),
        "reward": ("reward", "reward_clipping", "zero_sum"),
    }
)
"""The fields of a `Task` by group."""


def check_field(name: str, value: Any) -> Any:
    """The value of a field in the form that a `Task` stores.

    Raises:
        TypeError, ValueError: it is of the wrong kind or out of range.
    """
    return CHECKS[name](name, value)


def check_bool(name: str, value: Any) -> bool:
    """`value`, which must be True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise OptionTypeError(f"{name} must be True or False, got {value!r}")
    return bool(value)


def check_actions(name: str, value: Any) -> str | tuple[str, ...]:
    """ "minimal", "full", or the names of actions as a tuple.

    Raises:
        TypeError, ValueError: it is none of these, or a name occurs twice.
    """
    if isinstance(value, str):
        if value in ("minimal", "full"):
            return value
        raise ValueError(f"{name} must be 'minimal', 'full' or a list of names such as ['NOOP', 'FIRE'], got {value!r}")
    if not isinstance(value, Sequence) or not value:
        raise TypeError(f"{name} must be 'minimal', 'full' or a list of names such as ['NOOP', 'FIRE'], got {value!r}")
    known = [action.name for action in PLAYER_ACTIONS]
    names = tuple(one.name if isinstance(one, Action) else check_name(f"each of {name}", one, known) for one in value)
    if len(set(names)) < len(names):
        raise ValueError(f"{name} has a name twice: {', '.join(names)}")
    return names


def _check_probabilities(name: str, value: Any) -> float | tuple[float, ...]:
    """A probability, or one for each of several players."""
    if not isinstance(value, (list, tuple, np.ndarray)):
        return check_probability(name, value)
    each = tuple(check_probability(f"{name}[{player}]", one) for player, one in enumerate(value))
    return each[0] if len(set(each)) == 1 < len(each) else each


def _check_text(name: str, value: Any) -> str | None:
    if value is not None and not isinstance(value, str):
        raise TypeError(f"{name} must be a string or None, got {value!r}")
    return value


def _check_reward(name: str, value: Any) -> str | None:
    """The text of an expression in one line; `Task` checks it for its game."""
    if value is None:
        return None
    if not isinstance(value, str):
        raise OptionTypeError(
            f"{name} must be None, for the game's own, or an expression such as 'reward - 5 * lives_lost', "
            f"got {value!r:.80}"
        )
    return as_one_line(value)


def _shortest(value: float) -> float:
    """The shortest decimal number that is the same float32: 0.1, not 0.10000000149011612."""
    return float(str(np.float32(value)))


@dataclass(frozen=True)
class Whole:
    """The check of an integer within low..high."""

    low: int
    high: int

    def __call__(self, name: str, value: Any) -> int:
        """`value` as an int."""
        return check_integer(name, value, self.low, self.high)


@dataclass(frozen=True)
class Probability:
    """The check of a number within 0..1; `convert` gives it the form that a `Task` stores."""

    convert: Callable[[str, Any], Any]
    low: float = 0.0
    high: float = 1.0

    def __call__(self, name: str, value: Any) -> Any:
        """`value` in the form that a `Task` stores."""
        return self.convert(name, value)


@dataclass(frozen=True)
class OneOf:
    """The check of a name."""

    choices: tuple[str, ...]

    def __call__(self, name: str, value: Any) -> str:
        """`value`, which must be one of the choices."""
        return check_name(name, value, self.choices)


@dataclass(frozen=True)
class OrNone:
    """The check of a value that may be None."""

    check: Callable[[str, Any], Any]

    def __call__(self, name: str, value: Any) -> Any:
        """None, or `value` as `check` returns it."""
        return None if value is None else self.check(name, value)


@dataclass(frozen=True)
class Limit(OrNone):
    """The check of a limit; zero stands for none, as in ale-py."""

    def __call__(self, name: str, value: Any) -> Any:
        """`value` as `check` returns it; None in place of zero."""
        return super().__call__(name, value) or None


@dataclass(frozen=True)
class Noops:
    """The check of a range low..high, both included."""

    each: Whole

    def __call__(self, name: str, value: Any) -> tuple[int, int]:
        """`value` as (low, high)."""
        if not isinstance(value, (tuple, list)) or len(value) != 2:
            raise OptionTypeError(f"{name} must be (low, high), both included, such as (1, 30), got {value!r}")
        low, high = (self.each(name, one) for one in value)
        if low > high:
            raise ValueError(f"{name} must be (low, high) with low of at most high, got {value!r}")
        return low, high


@dataclass(frozen=True)
class FrameSkip:
    """The check of a number of frames, or of a range low..high-1 of it."""

    each: Whole

    def __call__(self, name: str, value: Any) -> int | tuple[int, int]:
        """`value` as a number of frames or as (low, high)."""
        return check_frameskip(value)


def _as_is(name: str, value: Any) -> Any:
    return value


CHECKS: Mapping[str, Callable[[str, Any], Any]] = {
    "game": _as_is,  # `Task` finds the game, and its modes, difficulties and interventions
    "rules": _check_text,
    "rom_md5": _check_text,
    "mode": _as_is,
    "difficulty": _as_is,
    "players": Whole(1, 4),
    "actions": check_actions,
    "continuous": check_bool,
    "continuous_action_threshold": Probability(lambda name, value: _shortest(check_probability(name, value))),
    "repeat_action_probability": Probability(_check_probabilities),
    "frameskip": FrameSkip(Whole(1, MOST_FRAMES_SKIPPED)),
    "interventions": _as_is,
    "noops": Noops(Whole(0, 1_000_000)),
    "fire": OneOf(get_args(Fire)),
    "fire_counts": check_bool,
    "third_action": check_bool,
    "fire_unit": OneOf(get_args(Unit)),
    "fire_again": check_bool,
    "seeding": OneOf(get_args(Seeding)),
    "episodic_life": check_bool,
    "lives_unit": OneOf(get_args(Unit)),
    "on_reset": OneOf(get_args(OnReset)),
    "last_life": check_bool,
    "seamless_lives": check_bool,
    "life_loss_info": check_bool,
    "max_num_frames_per_episode": Limit(Whole(0, NO_LIMIT)),
    "max_frames": OrNone(Whole(1, NO_LIMIT)),
    "max_episode_steps": OrNone(Whole(1, NO_LIMIT)),
    "obs_type": OneOf(get_args(ObsType)),
    "img_height": OrNone(Whole(1, 256)),
    "img_width": OrNone(Whole(1, 160)),
    "stack_num": OrNone(Whole(1, 256)),  # 26 MB of RGB images
    "maxpool": check_bool,
    "pool_rgb": check_bool,
    "padding": OneOf(get_args(Padding)),
    "end_frames": OneOf(get_args(EndFrames)),
    "sound_obs": check_bool,
    "agent_indicator": check_bool,
    "reward": _check_reward,
    "reward_clipping": check_bool,
    "zero_sum": check_bool,
}
"""The check of each field. Its attributes are the range that the field accepts; the tests draw from them."""
