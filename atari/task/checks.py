"""The checks of the fields of a `Task`, one field at a time; the tests draw values from their ranges.

A check returns the value in the form that a `Task` stores. It raises TypeError or ValueError for a wrong value.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atari.base.validation import OptionTypeError, check_frameskip, check_integer, check_name, check_probability
from atari.games.actions import PLAYER_ACTIONS, Action
from atari.games.rewards import as_one_line

Check = Callable[[str, Any], Any]

NO_LIMIT = 2**31 - 1
"""The highest limit of frames or steps."""


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


def check_probabilities(name: str, value: Any) -> float | tuple[float, ...]:
    """A probability, or one for each of several players."""
    if not isinstance(value, (list, tuple, np.ndarray)):
        return check_probability(name, value)
    each = tuple(check_probability(f"{name}[{player}]", one) for player, one in enumerate(value))
    return each[0] if len(set(each)) == 1 < len(each) else each


def check_text(name: str, value: Any) -> str | None:
    """`value`, which must be a string or None."""
    if value is not None and not isinstance(value, str):
        raise TypeError(f"{name} must be a string or None, got {value!r}")
    return value


def check_reward(name: str, value: Any) -> str | None:
    """The text of an expression in one line; `Task` checks it for its game."""
    if value is None:
        return None
    if not isinstance(value, str):
        raise OptionTypeError(
            f"{name} must be None, for the game's own, or an expression such as 'reward - 5 * lives_lost', "
            f"got {value!r:.80}"
        )
    return as_one_line(value)


def check_threshold(name: str, value: Any) -> float:
    """A probability as the shortest decimal number that is the same float32: 0.1, not 0.10000000149011612."""
    return float(str(np.float32(check_probability(name, value))))


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

    convert: Check
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

    check: Check

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
class Span:
    """The check of a range low..high, both included; with `or_number`, of a number, too."""

    each: Whole
    or_number: bool = False

    def __call__(self, name: str, value: Any) -> int | tuple[int, int]:
        """`value` as (low, high), or as a number if that is accepted and the only one of the range."""
        if not isinstance(value, (tuple, list)) or len(value) != 2:
            if self.or_number and not isinstance(value, (tuple, list, str)):
                return self.each(name, value)
            kind = "a number such as 3, or (low, high)" if self.or_number else "(low, high)"
            raise OptionTypeError(f"{name} must be {kind}, both included, such as (1, 30), got {value!r}")
        low, high = (self.each(name, one) for one in value)
        if low > high:
            raise ValueError(f"{name} must be (low, high) with low of at most high, got {value!r}")
        return low if self.or_number and low == high else (low, high)


@dataclass(frozen=True)
class FrameSkip:
    """The check of a number of frames, or of a range low..high-1 of it."""

    each: Whole

    def __call__(self, name: str, value: Any) -> int | tuple[int, int]:
        """`value` as a number of frames or as (low, high)."""
        return check_frameskip(value)


def as_is(name: str, value: Any) -> Any:
    """`value`, which `Task` checks for its game."""
    return value
