"""`atari explain`: the meaning of an environment ID."""

import argparse
from typing import TYPE_CHECKING, Any

from atari import registration
from atari.cli.arguments import add_command
from atari.cli.output import print_json
from atari.games.catalog import games

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands") -> None:
    """Add `atari explain`."""
    parser = add_command(commands, "explain", _explain, "explain what an environment ID means")
    parser.add_argument("id", metavar="ID", help="an ID, such as PongDeterministic-v4")


def _explain(args: argparse.Namespace) -> int:
    print_json(_facts(args.id)) if args.json else print(registration.explain(args.id))
    return 0


def _facts(env_id: str) -> dict[str, Any]:
    """Return what `registration.explain` prints, as data."""
    family, game_id = registration.resolve(env_id)
    game = games[game_id]
    shape = [128] if family.obs_type == "ram" else [*game.screen.shape, 3]
    siblings = {
        other.id(game_id): other.options(game_id) for other in registration.FAMILIES if game_id in other.games()
    }
    return {
        "id": env_id,
        "title": game.title,
        "options": siblings.pop(env_id),
        "observation": {"shape": shape, "dtype": "uint8"},
        "actions": game.minimal_actions,
        "modes": game.modes,
        "default_mode": game.default_mode,
        "difficulties": game.difficulties,
        "siblings": siblings,
    }
