"""`atari explain`: the meaning of an environment ID."""

import argparse
from typing import TYPE_CHECKING, Any

from atari import env_ids, registration
from atari.cli.arguments import GAME_HELP, add_command, find_game
from atari.cli.output import print_json
from atari.games.catalog import games
from atari.games.game import Game

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands") -> None:
    """Add `atari explain`."""
    parser = add_command(commands, "explain", _explain, "explain what an environment ID means")
    parser.add_argument("id", metavar="ID", help=f"an ID, such as PongDeterministic-v4, or {GAME_HELP}")


def _explain(args: argparse.Namespace) -> int:
    if args.id.endswith(".toml"):
        return _explain_own(find_game(args.id), args)
    env_id = args.id if "-v" in args.id or "/" in args.id else f"ALE/{env_ids.stem(find_game(args.id).id)}-v5"
    print_json(_facts(env_id)) if args.json else print(registration.explain(env_id))
    return 0


def _explain_own(game: Game, args: argparse.Namespace) -> int:
    """Explain what `atari.register_game` registers for a game of one's own."""
    ids = {f"{env_ids.stem(game.id)}{suffix}-v5": suffix for suffix in ("", "-ram")}
    if args.json:
        print_json({"id": None, "file": args.id, "title": game.title, "ids": list(ids), **_settings(game)})
        return 0
    actions = " ".join(action.name for action in game.minimal_actions)
    print(f"{args.id}: {game.title}, a game of your own")
    print(f"  IDs           {' and '.join(ids)}, after atari.register_game({args.id!r})")
    print(f"  observation   RGB screen ({game.screen.height}, 160, 3), uint8; with -ram the 128 bytes of RAM")
    print(f"  actions       {len(game.minimal_actions)}: {actions}")
    print(f"  mode          {game.default_mode} of {', '.join(map(str, game.modes))}")
    return 0


def _facts(env_id: str) -> dict[str, Any]:
    """Return what `registration.explain` prints, as data."""
    family, game_id = registration.resolve(env_id)
    game = games[game_id]
    shape = [128] if family.obs_type == "ram" else [*game.screen.shape, 3]
    siblings = {other.id(game_id): other.options(game_id) for other in env_ids.FAMILIES if game_id in other.games()}
    return {
        "id": env_id,
        "title": game.title,
        "options": siblings.pop(env_id),
        "observation": {"shape": shape, "dtype": "uint8"},
        **_settings(game),
        "siblings": siblings,
    }


def _settings(game: Game) -> dict[str, Any]:
    return {
        "actions": game.minimal_actions,
        "modes": game.modes,
        "default_mode": game.default_mode,
        "difficulties": game.difficulties,
    }
