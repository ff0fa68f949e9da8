"""Checks of arguments that users pass, for all parts of the package.

Each function returns the checked value. It raises `TypeError` for a value of the wrong kind and `ValueError` for a
value out of range; the message has the argument's name, what is accepted, and the value. Where ale-py raises
`gymnasium.error.Error`, the errors are of that kind too.
"""

import difflib
import inspect
import math
import operator
import stat
from collections.abc import Iterable
from enum import Enum
from pathlib import Path
from typing import Any

import gymnasium

MOST_FRAMES_SKIPPED = 10_000
"""The highest frame skip."""


class AleError(ValueError, RuntimeError):
    """A value that is not accepted, where ale-py raises `RuntimeError`."""


class AleTypeError(TypeError, ValueError):
    """A value that is not accepted, where ale-py raises `TypeError`."""


class FirstResetNeeded(gymnasium.error.ResetNeeded, RuntimeError):
    """A mask selected some environments before the first reset of all; ale-py raises `RuntimeError`."""


class OptionTypeError(TypeError, gymnasium.error.Error):
    """An option is of the wrong kind."""


class OptionValueError(ValueError, gymnasium.error.Error):
    """An option has a value that is not accepted."""


def as_integer(value: Any) -> int | None:
    """`value` as an int; None for a bool, and for what is no integer of Python or NumPy."""
    try:
        return None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return None


def check_integer(name: str, value: Any, low: int, high: int) -> int:
    """`value` as an int within low..high, see `as_integer`."""
    number = as_integer(value)
    if number is None:
        raise TypeError(f"{name} must be an integer within {low}..{high}, got {value!r}")
    if not low <= number <= high:
        raise ValueError(f"{name} must be within {low}..{high}, got {number}")
    return number


def check_probability(name: str, value: Any) -> float:
    """`value` as a float within 0..1."""
    try:
        number = math.nan if isinstance(value, (bool, str)) else float(value)
    except (OverflowError, TypeError, ValueError):
        number = math.nan
    if math.isnan(number):
        raise TypeError(f"{name} must be a number within 0..1, got {value!r}")
    if not 0.0 <= number <= 1.0:
        raise ValueError(f"{name} must be within 0..1, got {number}")
    return number


def check_name(name: str, value: Any, choices: Iterable[str]) -> str:
    """`value`, which must be one of `choices`."""
    choices = tuple(choices)
    if value not in choices:
        raise OptionValueError(f"{name} must be one of {', '.join(map(repr, choices))}, got {value!r}")
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


def check_action_index(action: Any, count: int, game: str) -> int:
    """`action` as an index 0..`count`-1 into the action set of an environment of `game`."""
    check_no_name(action, count)
    try:
        index = operator.index(action)
    except TypeError:
        raise TypeError(f"an action is an integer within 0..{count - 1}, got {action!r}") from None
    if not 0 <= index < count:
        raise ValueError(f"action {index} is not within 0..{count - 1} ({game})")
    return index


def check_no_name(action: Any, count: int) -> None:
    """Refuse a member of `Action`, whose number is an index only in a set of all 18 actions."""
    if isinstance(action, Enum) and count < 18:
        raise TypeError(
            f"an action is an index 0..{count - 1} of this environment's actions, and "
            f"{type(action).__name__}.{action.name} is an ALE action; pass "
            f"env.unwrapped.get_action_meanings().index({action.name!r})"
        )


def check_strength(strength: Any) -> float:
    """`strength` as a finite float that cannot overflow a paddle's position."""
    try:
        number = None if isinstance(strength, str) else float(strength)
    except (OverflowError, TypeError, ValueError):
        number = None
    if number is None:
        raise TypeError(f"strength must be a number, got {strength!r}")
    if not abs(number) <= 1000.0:  # written so that NaN fails too
        raise ValueError(f"strength must be finite and at most 1000 in magnitude, got {number}")
    return number


def check_poke(index: Any, value: Any) -> tuple[int, int]:
    """The arguments of `set_ram` as two ints."""
    if isinstance(index, int) and 128 <= index <= 255:
        raise ValueError(
            f"index must be within 0..127, got {index}; the address ${index:02X} has the index {index - 128}"
        )
    return check_integer("index", index, 0, 127), check_integer("value", value, 0, 255)


def check_frameskip(frameskip: Any) -> int | tuple[int, int]:
    """`frameskip` as a number of frames, or as (low, high).

    Raises:
        TypeError, ValueError: it is neither, or the range low..high-1 is empty.
    """
    if not isinstance(frameskip, (tuple, list)):
        return _check_frames(frameskip)
    if len(frameskip) != 2:
        raise OptionValueError(f"a frameskip range is (low, high), got {frameskip!r}")
    low, high = map(_check_frames, frameskip)
    if low >= high:
        raise OptionValueError(
            f"a frameskip range (low, high) is low..high-1 frames and needs low < high, got {frameskip!r}"
        )
    return low, high


def check_file(file: Path, instead: str = "give a regular file") -> Path:
    """`file`, which must be a regular file: to open a pipe or a device could block or read for ever.

    Args:
        file: the path; symbolic links are followed.
        instead: what to do if it is a folder, for the message.

    Raises:
        FileNotFoundError, PermissionError: there is no such file, or a folder of its path is closed.
        IsADirectoryError: it is a folder.
        ValueError: it is a device, a pipe or a socket, or the path has a null character.
    """
    try:
        mode = file.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(f"there is no file {file}; check the path") from None
    except PermissionError:
        raise PermissionError(f"{file} may not be read; check the permissions of its folders") from None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(f"{file} is a folder; {instead}")
    if not stat.S_ISREG(mode):
        raise ValueError(f"{file} is a device or a pipe; give a regular file")
    return file


# Names of other projects' options that are too unlike ours to be found by their letters.
_OTHER_NAMES = {
    "stack_num": "frame_stack n_stack stack_size",
    "img_height": "screen_size image_size size shape",
    "obs_type": "gray_scale grayscale grayscale_obs obs",
    "repeat_action_probability": "sticky sticky_actions",
    "episodic_life": "terminal_on_life_loss",
    "noops": "noop_max",
    "fire": "use_fire_reset",
    "agent_indicator": "player_indicator",
    "max_episode_steps": "max_cycles",
    "players": "num_players",
}
_OURS = {other: name for name, others in _OTHER_NAMES.items() for other in others.split()}

_OF_VECTORS = frozenset(("num_envs", "num_threads", "batch_size", "autoreset_mode", "channels_last"))
"""Options of `AtariVectorEnv` that mean nothing for a single environment."""


def check_known(owner: str, wrong: Iterable[str], known: Iterable[str]) -> None:
    """Refuse options that do not exist.

    Raises:
        TypeError: `wrong` is not empty; the message suggests the nearest of the known names, or `AtariVectorEnv` for
            an option that only vectors have.
    """
    known = tuple(dict.fromkeys(known))
    names = {_sorted_words(name): name for name in (*_OF_VECTORS, *known)}
    for name in wrong:
        words = _sorted_words(_OURS.get(name, name))
        near = [names[match] for match in difflib.get_close_matches(words, names, n=1, cutoff=0.5)]
        if not near:
            hint = f"it has {', '.join(known)}"
        elif near[0] in known:
            hint = f"did you mean {near[0]!r}?"
        else:
            hint = f"AtariVectorEnv, which plays many environments, has {near[0]!r}"
        raise TypeError(f"{owner} has no option {name!r}; {hint}")


def check_arguments(owner: str, kind: type, given: Iterable[str]) -> None:
    """Refuse names of arguments that `kind`, which users make as `owner`, does not have; see `check_known`."""
    _, *known = inspect.signature(kind.__init__).parameters  # type: ignore[misc]
    check_known(owner, [name for name in given if name not in known], known)


def _sorted_words(name: str) -> str:
    """`num_stack` and `stack_num` alike."""
    return "_".join(sorted(name.split("_")))


def _check_frames(frames: Any) -> int:
    try:
        return check_integer("frameskip", frames, 1, MOST_FRAMES_SKIPPED)
    except TypeError as error:
        raise OptionTypeError(str(error)) from None
    except ValueError as error:
        raise OptionValueError(str(error)) from None
