"""The arguments of commands: the declaration of commands, and types of arguments."""

import argparse
import difflib
import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

from atari.games.catalog import games
from atari.games.game import Game
from atari.task.arguments import StoreOnce, advised, field_of_flag, read_game
from atari.task.task import look_up

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


class HelpFormatter(argparse.HelpFormatter):
    """A formatter whose usage is short: required arguments, and [options] for the others, which the help lists."""

    def add_usage(
        self, usage: str | None, actions: Iterable[argparse.Action], groups: Any, prefix: str | None = None
    ) -> None:
        """Add the usage; a parser with subcommands keeps its own."""
        actions = list(actions)
        shown = [action for action in actions if action.required or not action.option_strings]
        if shown != actions and not any(isinstance(action, argparse._SubParsersAction) for action in actions):
            actions, groups = [*shown, argparse.Action([], "", metavar="[options]")], []
        super().add_usage(usage, actions, groups, prefix)


class Parser(argparse.ArgumentParser):
    """An argument parser with a short usage, options at any place, and errors that suggest the nearest name."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **{"formatter_class": HelpFormatter, "allow_abbrev": False, **options})
        self._intermixed = False
        for kind in (None, "store"):
            self.register("action", kind, StoreOnce)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse; an option may precede an optional argument, such as the games of `evaluate`."""
        if self._intermixed or any(action.nargs in (argparse.PARSER, argparse.REMAINDER) for action in self._actions):
            return super().parse_known_args(args, namespace)
        self._intermixed = True  # for nested calls of this method
        try:
            return self.parse_known_intermixed_args(args, namespace)
        finally:
            self._intermixed = False

    def error(self, message: str) -> NoReturn:
        """Print the usage and the error, with a suggestion, and exit with code 2."""
        chosen = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        unknown = re.match(r"unrecognized arguments: (--[\w-]+)", message)
        near: list[str] = []
        field = field_of_flag(unknown[1]) if unknown else None
        if unknown and field is not None:
            message = f"{self.prog} has no place for {unknown[1]}, the field {field!r} of a task; leave it out"
        elif unknown and unknown[1] == "--json":
            message = "--json stands after the command's name"
        elif chosen:
            near = difflib.get_close_matches(chosen[1], re.findall(r"[\w.-]+", chosen[2]), n=1)
        else:
            message = advised(message, self._option_string_actions)
        super().error(f"{message}; did you mean {near[0]!r}?" if near else message)


GAME_HELP = (
    "a game, such as breakout, its ROM, such as Breakout.a26, an ID, such as PongNoFrameskip-v4, a game definition, "
    "such as own.toml, or a task, such as task.json, which `atari info GAME --print-task --json` prints"
)


def add_command(
    commands: Commands, name: str, run: Callable[[argparse.Namespace], int], help_: str
) -> argparse.ArgumentParser:
    """Add a command with the option --json. `run` gets the parsed arguments and returns the exit code."""
    parser = commands.add_parser(name, help=help_, description=f"{help_[0].upper()}{help_[1:]}.")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.set_defaults(run=run, parser=parser)
    return parser


def add_rom(parser: argparse.ArgumentParser) -> None:
    """Add the option --rom, for the user's own game definitions."""
    parser.add_argument(
        "--rom",
        type=Path,
        metavar="FILE",
        help="the ROM of a game definition (default: the file beside it with the ending .bin or .a26)",
    )


def find_game(name: str, playable: bool = True) -> Game:
    """The game of an argument: a game's name, an ID, the file of a game definition (.toml), or a task (.json).

    With `playable`, two-player cartridges are an error.

    Raises:
        ValueError, FileNotFoundError, gymnasium.error.NameNotFound: there is no such game; the message suggests
            the nearest.
    """
    game = look_up(read_game(name)).definition
    return games.find(game) if playable else game


def number(kind: type[int] | type[float], low: float, high: int = 10**9) -> Callable[[str], float]:
    """Return an argparse type that accepts numbers within `low`..`high`."""

    def parse(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{text!r:.40} is not {_KINDS[kind]} within {low}..{high}")
        return value

    return parse


_KINDS = {int: "a whole number", float: "a number"}
