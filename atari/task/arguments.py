"""GAME and the options of a `Task` on a command line: flags made from the rows of its fields."""

import argparse
import inspect
import json
import os
import re
from collections import defaultdict
from collections.abc import Collection, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from atari.base import magic
from atari.base.frozen import FrozenDict
from atari.base.program import print_exact
from atari.base.typed_table import from_text
from atari.base.validation import check_file
from atari.roms.identification import identify
from atari.roms.search import ENDINGS
from atari.task.description import summary
from atari.task.fields import DEFAULTS, GROUPS, ROWS, TYPES, check_field
from atari.task.parser import as_type, flags_of
from atari.task.presets import PRESETS, find_preset
from atari.task.resolution import OPTIONS
from atari.task.task import FoundGame, GameLike, Task, fix_fields, look_up

SCREEN: Mapping[str, Any] = FrozenDict(
    {name: DEFAULTS[name] for name in (*GROUPS["observation"], "reward", "reward_clipping")}
)
"""The fields for an agent's observations and rewards, with their values when a person sees the screen."""


def add_task(
    parser: argparse.ArgumentParser,
    groups: Collection[str] = tuple(GROUPS),
    refused: Collection[str] = (),
    *,
    fixed: Mapping[str, Any] = FrozenDict(),
    preset: bool = True,
) -> None:
    """Add `--preset`, a flag for each option of a task that a command obeys, and `--print-task`.

    Args:
        parser: the parser of a command, which adds GAME itself. A flag that is not given leaves no attribute in its
            namespace; only `preset` is then None.
        groups: the groups of fields that the command obeys, see `atari.task.fields.GROUPS`, and names of options.
        refused: options of these groups that the command does not obey.
        fixed: options that do not matter for the command, such as observations when a person sees the screen, with
            the values that it plays. They have no flags; if GAME has other values, the first line says so.
        preset: whether the command has `--preset`.
    """
    own = parser.add_argument_group("what is played", "Fields of atari.Task, which override GAME and the preset.")
    if preset:
        names = ", ".join(PRESETS)
        own.add_argument("--preset", type=as_type(_preset), metavar="NAME", help=f"a preprocessing: {names}")
    own.add_argument("--print-task", action="store_true", help="print what would be played, and end")
    options = (name for group in groups for name in GROUPS.get(group, (group,)))
    obeyed = [name for name in options if name in OPTIONS and name not in refused]
    sections: dict[str, Any] = {}
    for name in obeyed:
        title = ROWS[name].group
        section = sections.get(title) or parser.add_argument_group(f"what is played: {title}")
        sections[title] = section
        _add_flag(section, name)
        if name == "actions":
            section.add_argument(
                "--full-action-space",
                action="store_true",
                default=argparse.SUPPRESS,
                help="another name of --actions full",
            )
    parser.set_defaults(obeyed=tuple(obeyed), fixed=fixed, command=parser.prog)


def _add_flag(group: Any, name: str) -> None:
    row, flags = ROWS[name], flags_of(name)
    common: dict[str, Any] = {"dest": name, "default": argparse.SUPPRESS, "help": row.says.replace("%", "%%")}
    if TYPES[name] is bool:
        group.add_argument(*flags, action=argparse.BooleanOptionalAction, **common)
    elif name == "interventions":
        common["help"] += "; may be repeated"
        group.add_argument(*flags, action="append", type=as_type(_one_name), metavar=row.metavar, **common)
    else:
        choices = get_args(TYPES[name]) if get_origin(TYPES[name]) is Literal else ()
        metavar = row.metavar or "|".join(choices) or "N"
        group.add_argument(*flags, type=as_type(partial(field_from_text, name)), metavar=metavar, **common)


def _one_name(text: str) -> str:
    if "," in text and "#" not in text:  # the path before # may have a comma
        raise ValueError(f"{text!r} has a comma; give the option once for each name")
    return text


def read_task(path: Path) -> Task:
    """The task of a file.

    Raises:
        FileNotFoundError, ValueError: there is no such file, or it contains no task.
    """
    check_file(path)
    with path.open("rb") as file:
        data = file.read((1 << 20) + 1)
    try:
        return Task.from_json(data.decode(errors="replace"))
    except ValueError as error:
        raise ValueError(f"{path} has no task: {error}") from None


def given_options(args: argparse.Namespace) -> dict[str, Any]:
    """The options of a task on a command line by name, for `Task.of`."""
    given = {name: getattr(args, name) for name in (*OPTIONS, "full_action_space") if hasattr(args, name)}
    return {**given, "interventions": tuple(given["interventions"])} if "interventions" in given else given


def read_game(text: str) -> GameLike:
    """GAME of a command line: an ID, a game's name, the path of a game file, or the task of a file *.json.

    A ROM file stands for its game.

    The path is absolute, so that a stored task stays valid.

    Raises:
        FileNotFoundError, TypeError, ValueError: there is no such file, or it holds no task; or it is another file or
            folder, as a ROM, a policy or a replay.
    """
    if text.endswith(".json"):
        return read_task(Path(text))
    path = Path(text)
    if text.endswith(".toml"):
        return path.absolute()
    if path.suffix.lower() in ENDINGS and path.is_file() and not magic.begins_with(path, magic.REPLAY):
        rom = identify(path)
        if rom.game is None:
            raise ValueError(f"{rom}; a game of your own is named by its definition (.toml), with --rom {text}")
        return rom.game.id  # the file that is found has the same bytes
    if (os.sep in text or path.suffix) and path.exists():
        raise ValueError(
            f"GAME is a game, its ROM, a task (.json) or a definition (.toml), and {text} is another file or folder; "
            f"name the game, and give a policy or a replay by the option for it, as `atari record breakout --policy "
            f"{text}`; `atari replay show` has the facts of a replay"
        )
    return text


def task_of(
    args: argparse.Namespace, game: str | FoundGame | None = None, *, agent: bool = False, **others: Any
) -> Task:
    """The task of the arguments of a command.

    Args:
        args: parsed by a parser with `add_task`.
        game: GAME, or what it names; None is `args.game`.
        agent: whether an agent plays, which needs the preprocessing of a preset; see `FoundGame.task_for_agent`.
        **others: arguments of `FoundGame.task` or `task_for_agent`, such as `base` or `default`.

    Raises:
        gymnasium.error.NameNotFound, ValueError, FileNotFoundError: see `Task.of`; ValueError replaces its TypeErrors,
            and is raised for a field that the command does not obey.
    """
    try:
        text = args.game if game is None else game
        found = look_up(read_game(text)) if isinstance(text, str) else text
        make = found.task_for_agent if agent else found.task
        task = make(getattr(args, "preset", None), given_options(args), owner="Task", **others)
        task, args.without = fix_fields(task, args.obeyed, args.fixed, f"`{args.command}`")
        return task
    except TypeError as error:
        raise ValueError(str(error)) from None


def show_task(args: argparse.Namespace, task: Task) -> bool:
    """Print the task: in a line, or with --print-task as a table, or with both and --json as a JSON document.

    Returns:
        Whether the command ends after that.
    """
    as_json = getattr(args, "json", False)
    if args.print_task:
        print_exact(f"{json.dumps(json.loads(task.to_json()), indent=2) if as_json else task}\n")
    elif not as_json:
        without = "".join(f", without {name}={value!r}" for name, value in getattr(args, "without", {}).items())
        print(f"{summary(task)}{without}", flush=True)
    return bool(args.print_task)


def field_from_text(name: str, text: str) -> Any:
    """The value of an option of a task from its text: a number, a word, "none", or several with commas between.

    Raises:
        TypeError, ValueError: the text is no such value; the message says what is accepted.

    Example:
        >>> from atari.task.arguments import field_from_text
        >>> field_from_text("frameskip", "2,5"), field_from_text("actions", "FIRE"), field_from_text("reward", "none")
        ((2, 5), ('FIRE',), None)
    """
    value = from_text(text, TYPES[name])
    alone = name == "actions" and isinstance(value, str) and value not in ("minimal", "full")
    return check_field(name, (value,) if alone else value)


def descriptions(owner: type) -> dict[str, str]:
    """The text about each option in the docstrings of a class of options and of its bases, by name.

    Options have no text where Python leaves docstrings out (`python -OO`).
    """
    found: dict[str, str] = defaultdict(str)
    for base in reversed(owner.__mro__):
        # Python 3.13 takes the indentation off docstrings when it compiles them; cleandoc does so for older ones.
        section = inspect.cleandoc(base.__doc__ or "").partition("Attributes:\n")[2]
        for name, text in re.findall(r"^ {4}(\w+): (.*(?:\n {8}.*)*)", section, re.MULTILINE):
            found[name] = re.sub(r"\s+", " ", text).rstrip(".")
    return found


def _preset(name: str) -> str:
    find_preset(name)
    return name
