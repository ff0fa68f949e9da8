"""`atari list`: the games, or every environment ID."""

import argparse
from collections.abc import Iterator
from typing import Any

from atari.cli.arguments import Commands, add_command
from atari.cli.printing import print_json, print_table
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.pettingzoo import ENVIRONMENTS
from atari.task import env_ids


def register(commands: Commands) -> None:
    """Add `atari list`."""
    parser = add_command(commands, "list", _list, "list the games, or with --ids every environment ID")
    parser.add_argument("--ids", action="store_true", help="the IDs that gymnasium.make accepts, one a line")
    parser.add_argument(
        "--players", type=int, choices=(2, 4), help="list the environments of atari.multiplayer for 2 or 4 players"
    )


def _list(args: argparse.Namespace) -> int:
    if args.players:
        rows = [*_multiplayer_rows(args.players)]
        names = ("environment", "game", "players", "actions")
        print_json([dict(zip(names, row, strict=True)) for row in rows]) if args.json else print_table([names, *rows])
    elif args.ids:
        ids = [*env_ids.ids()]
        print_json(ids) if args.json else print("\n".join(ids))
    elif args.json:
        print_json([_summary(game) for game in games.values()])
    else:
        print_table([("game", "title", "actions", "modes", "difficulties"), *map(_row, games.values())])
    return 0


def _multiplayer_rows(players: int) -> Iterator[tuple[str, str, int, int]]:
    """PettingZoo's environments for a number of players, then the other games."""
    named = {environment.game for environment in ENVIRONMENTS.values()}
    for environment in ENVIRONMENTS.values():
        rules = games[environment.game].multiplayer
        if rules and players in environment.players:
            yield environment.id, environment.game, players, len(rules.minimal_actions)
    for game in games.values():
        if game.multiplayer and game.id not in named and players in game.multiplayer.modes:
            yield game.id, game.id, players, len(game.multiplayer.minimal_actions)


def _summary(game: Game) -> dict[str, Any]:
    return {
        "id": game.id,
        "title": game.title,
        "single_player": game.single_player,
        "actions": len(game.minimal_actions),
        "modes": len(game.modes),
        "difficulties": len(game.difficulties),
    }


def _row(game: Game) -> tuple[object, ...]:
    if not game.single_player:
        return game.id, f"{game.title} ({game.players} players: see --players)", "-", "-", "-"
    return game.id, game.title, len(game.minimal_actions), len(game.modes), len(game.difficulties)
