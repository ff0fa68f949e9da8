"""The options of a `Task` as flags of a command line, made from the fields of the class and from its docstring."""

import argparse
import re
import typing
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

from atari.task.fields import GROUPS, check_field
from atari.task.presets import PRESETS, find_preset
from atari.task.resolution import OPTIONS
from atari.task.task import DEFAULTS, Task

_NAMES: Mapping[str, tuple[str, ...]] = {
    "repeat_action_probability": ("--repeat-action-probability", "--sticky"),
    "interventions": ("--intervention",),
}
"""The flags of options that have others than their name."""

_METAVARS: Mapping[str, str] = {
    "actions": "full|NAMES",
    "frameskip": "N|LOW,HIGH",
    "noops": "LOW,HIGH",
    "interventions": "NAME",
    "repeat_action_probability": "P",
    "continuous_action_threshold": "P",
}

_MAY_BE_NONE = frozenset(name for name in OPTIONS if DEFAULTS[name] is None) | {"max_num_frames_per_episode"}
"""Options for which the text "none" is a value."""


def add_flags(
    parser: argparse.ArgumentParser,
    groups: Collection[str] = tuple(GROUPS),
    leave_out: Collection[str] = (),
    preset: bool = True,
) -> None:
    """Add `--preset`, and a flag of each option of a task.

    Args:
        parser: of a command. Flags that are not given leave no attribute in its namespace, but `preset`, which is None.
        groups: the groups of fields that the command obeys, see `atari.task.fields.GROUPS`, and names of options.
        leave_out: options of these groups that the command does not obey.
        preset: whether the command has `--preset`.
    """
    own = parser.add_argument_group("what is played", "Fields of atari.Task, which override GAME and the preset.")
    if preset:
        own.add_argument("--preset", type=_preset, metavar="NAME", help=f"a preprocessing: {', '.join(PRESETS)}")
    texts = descriptions(Task)
    for name in (name for group in groups for name in GROUPS.get(group, (group,))):
        if name not in OPTIONS or name in leave_out:
            continue
        _add_flag(own, name, texts[name].replace("%", "%%"))
        if name == "actions":
            own.add_argument(
                "--full-action-space",
                action="store_true",
                default=argparse.SUPPRESS,
                help="another name of --actions full",
            )


def _add_flag(group: Any, name: str, text: str) -> None:
    flags = _NAMES.get(name, (f"--{name.replace('_', '-')}",))
    common: dict[str, Any] = {"dest": name, "default": argparse.SUPPRESS, "help": text}
    if _kinds()[name] is bool:
        group.add_argument(*flags, action=argparse.BooleanOptionalAction, **common)
    elif name == "interventions":
        group.add_argument(*flags, action="append", metavar="NAME", **{**common, "help": f"{text}; may be repeated"})
    else:
        group.add_argument(*flags, type=_reader(name), metavar=_metavar(name), **common)


def given_options(args: argparse.Namespace) -> dict[str, Any]:
    """The options of a task that a command line has, by name, as `Task.of` takes them."""
    given = {name: getattr(args, name) for name in (*OPTIONS, "full_action_space") if hasattr(args, name)}
    return {**given, "interventions": tuple(given["interventions"])} if "interventions" in given else given


def option_of(name: str, text: str) -> Any:
    """The value of an option of a task from its text: a number, a word, "none", or several with commas between.

    Raises:
        TypeError, ValueError: the text is none; the message says what is accepted.

    Example:
        >>> from atari.task.arguments import option_of
        >>> option_of("frameskip", "2,5"), option_of("actions", "NOOP,FIRE"), option_of("stack_num", "none")
        ((2, 5), ('NOOP', 'FIRE'), None)
    """
    if text == "none" and name in _MAY_BE_NONE:
        return None
    words = tuple(_number(word) for word in text.split(","))
    several = len(words) > 1 or (name == "actions" and text not in ("minimal", "full"))
    return check_field(name, words if several else words[0])


def descriptions(owner: type) -> dict[str, str]:
    """What the docstrings of a class of options and of its bases say about each option, by name."""
    found: dict[str, str] = {}
    for base in reversed(owner.__mro__):
        section = (base.__doc__ or "").partition("Attributes:\n")[2]
        for name, text in re.findall(r"^ {8}(\w+): (.*(?:\n {12}.*)*)", section, re.MULTILINE):
            found[name] = re.sub(r"\s+", " ", text).rstrip(".")
    return found


def _reader(name: str) -> Any:
    def read(text: str) -> Any:
        try:
            return option_of(name, text)
        except (TypeError, ValueError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return read


def _preset(name: str) -> str:
    try:
        find_preset(name)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return name


def _number(word: str) -> Any:
    """A word as a number, if it is one. 1e5 is a whole number, too."""
    with suppress(ValueError):
        value = float(word)
        return int(value) if value.is_integer() else value
    return word


def _metavar(name: str) -> str:
    kind = _kinds()[name]
    if typing.get_origin(kind) is typing.Literal:
        return "|".join(typing.get_args(kind))
    return _METAVARS.get(name, "N")


def _kinds() -> dict[str, Any]:
    """The type of each field."""
    return typing.get_type_hints(Task)
