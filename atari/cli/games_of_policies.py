"""The games that `evaluate`, `watch` and `collect` let a policy play."""

import argparse
from collections.abc import Sequence
from typing import Any

from atari.cli.task_arguments import game_or_file
from atari.learning.evaluation.played import Entry, find_entries
from atari.task.arguments import add_flags, given_options

_OF_GAME = ("mode", "difficulty", "interventions")
"""Fields that the game decides where an evaluation protocol, or the policy's training, decides the others."""


def add_game_options(parser: argparse.ArgumentParser) -> None:
    """Add flags of the options that the game decides: its mode, its difficulty, and interventions."""
    add_flags(parser, _OF_GAME, preset=False)


def find_played(args: argparse.Namespace, names: Sequence[str], policy: Any = None) -> tuple[Entry, ...]:
    """The games of a command line with `add_game_options`, or without names that of the policy's training.

    Args:
        args: parsed.
        names: of games, IDs, sets of games, or files.
        policy: of the training; its mode, difficulty and interventions are played, too.

    Raises:
        gymnasium.error.NameNotFound, ValueError, FileNotFoundError: there is no such game, or none is named.
    """
    games: list[Any] = [game_or_file(name) for name in names]
    if not games:
        games = [getattr(policy, "task", None) or getattr(policy, "game", None)]
    if games == [None]:
        raise ValueError(f"{args.source} does not say which game it plays; name games or a set, such as atari26")
    try:
        return find_entries(games, given_options(args))
    except TypeError as error:
        raise ValueError(str(error)) from None
