"""GAME and the flags of a task, as arguments of the commands that play a game."""

import argparse
import json
from collections.abc import Collection
from os import PathLike
from pathlib import Path
from typing import Any

from atari.cli.output import print_json
from atari.task import Task
from atari.task.arguments import add_flags, given_options
from atari.task.fields import GROUPS
from atari.task.resolution import resolve_for_agent, resolve_task
from atari.validation import check_integer

SEEDS = 2**32
"""Seeds of all commands are below it."""


def add_task(
    parser: argparse.ArgumentParser, groups: Collection[str] = tuple(GROUPS), leave_out: Collection[str] = ()
) -> None:
    """Add `--preset`, a flag of each option of a task, and `--print-task`. The command adds GAME itself.

    Args:
        parser: of a command.
        groups: the groups of fields that the command obeys, see `atari.task.fields.GROUPS`, and names of options.
        leave_out: options of these groups that the command does not obey.
    """
    add_flags(parser, groups, leave_out)
    parser.add_argument("--print-task", action="store_true", help="print what would be played, and end")


def task_of(args: argparse.Namespace, *, game: str | None = None, agent: bool = False, **others: Any) -> Task:
    """The task of the arguments of a command.

    Args:
        args: parsed by a parser with `add_task`.
        game: an ID, a game's name or the path of a game file; None is `args.game`.
        agent: whether an agent plays, which needs the preprocessing of a preset; see `resolve_for_agent`.
        **others: of `resolve_task` or `resolve_for_agent`, such as `base` or `default`.

    Raises:
        gymnasium.error.NameNotFound, ValueError, FileNotFoundError: as `Task.of`; ValueError also for its TypeErrors.
    """
    resolve = resolve_for_agent if agent else resolve_task
    try:
        return resolve(
            game_or_file(args.game if game is None else game),
            getattr(args, "preset", None),
            given_options(args),
            owner="Task",
            **others,
        )
    except TypeError as error:
        raise ValueError(str(error)) from None


def game_or_file(name: str) -> str | PathLike[str]:
    """GAME as the resolvers take it: the path of a game file is absolute, so that what is stored stays valid."""
    return Path(name).absolute() if name.endswith(".toml") else name


def print_task(task: Task, as_json: bool) -> None:
    """Print a task for `--print-task`: as a table, or as one JSON document."""
    print_json(json.loads(task.to_json())) if as_json else print(task)


def seed(text: str) -> int:
    """An argparse type: a seed, 0..2**32 - 1."""
    try:
        return check_integer("a seed", int(text), 0, SEEDS - 1)
    except ValueError as error:
        word = str(error) if "within" in str(error) else f"a seed must be a whole number, got {text!r}"
        raise argparse.ArgumentTypeError(word) from None
