"""The arguments of commands: the declaration of a command, GAME and --rom."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from atari.games.catalog import games
from atari.games.game import Game
from atari.task.arguments import read_game
from atari.task.task import look_up

Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"


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
