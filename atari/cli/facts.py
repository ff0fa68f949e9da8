"""`atari list`, `atari info` and `atari explain`: what the library knows about games and environment IDs."""

import argparse
from typing import TYPE_CHECKING, Any

from atari import registration
from atari.catalog import games
from atari.cli.command import add_command, plain, print_json, print_table
from atari.game import Controllers, Game
from atari.rules import Rules

if TYPE_CHECKING:
    from atari.cli.command import Commands


def add_commands(commands: "Commands") -> None:
    """Add the commands of this file."""
    parser = add_command(commands, "list", _list, "list the games, or with --ids every environment ID")
    parser.add_argument("--ids", action="store_true", help="the IDs that gymnasium.make takes, one a line")
    parser = add_command(commands, "info", _info, "show what is known about a game")
    parser.add_argument("game", metavar="GAME", help="a game, such as breakout")
    parser = add_command(commands, "explain", _explain, "explain what an environment ID means")
    parser.add_argument("id", metavar="ID", help="an ID, such as PongDeterministic-v4")


def _list(args: argparse.Namespace) -> int:
    if args.ids:
        ids = list(registration.ids())
        print_json(ids) if args.json else print("\n".join(ids))
    elif args.json:
        print_json([_summary(game) for game in games.values()])
    else:
        print_table([("game", "title", "actions", "modes", "difficulties"), *map(_row, games.values())])
    return 0


def _info(args: argparse.Namespace) -> int:
    if args.game not in games:
        raise ValueError(games.unknown(args.game))
    game = games[args.game]
    ids = [family.id(game.id) for family in registration.FAMILIES if game.id in family.games()]
    print_json({**plain(game), "ids": ids}) if args.json else print(_description(game, ids))
    return 0


def _explain(args: argparse.Namespace) -> int:
    print_json(_meaning(args.id)) if args.json else print(registration.explain(args.id))
    return 0


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
        return game.id, f"{game.title} ({game.players} players, no environment)", "-", "-", "-"
    return game.id, game.title, len(game.minimal_actions), len(game.modes), len(game.difficulties)


def _description(game: Game, ids: list[str]) -> str:
    screen, rom = game.screen, game.rom
    facts: list[tuple[str, list[Any]]] = [
        ("players", [game.players]),
        ("screen", [f"{screen.width} columns, {screen.height} rows, {screen.format}"]),
        ("controllers", [_controllers(game.controllers)]),
        *(_settings(game) if game.rules else []),
        ("rules", _rules(game.rules) if game.rules else ["none for a single player, so there is no environment"]),
        ("RAM", [f"{len(game.ram_labels)} names for bytes of it"]),
        ("ROM", [f"{rom.size} bytes, {rom.cartridge}, MD5 {rom.md5}"]),
        ("notes", list(game.notes)),
        ("IDs", ids),
    ]
    lines = [f"{game.id}: {game.title}"]
    for name, values in facts:
        lines += [f"  {'' if i else name:12}  {value}" for i, value in enumerate(values)]
    return "\n".join(lines)


def _settings(game: Game) -> list[tuple[str, list[Any]]]:
    """Actions, modes and difficulties."""
    names = " ".join(action.name for action in game.minimal_actions)
    return [
        ("actions", [f"{len(game.minimal_actions)} of {len(game.legal_actions)}: {names}"]),
        ("starts with", [" ".join(action.name for action in game.starting_actions) or "no action"]),
        ("modes", [f"{', '.join(map(str, game.modes))} (default {game.default_mode})"]),
        ("difficulties", [", ".join(map(str, game.difficulties))]),
    ]


def _rules(rules: Rules) -> list[str]:
    """What holds at a reset, and what follows from RAM after each frame."""
    at_reset = {"lives": rules.lives_initial, **rules.state}
    return [
        "at reset: " + ", ".join(f"{name} = {value}" for name, value in at_reset.items()),
        *(f"{name} = {expression}" for name, expression in rules.step),
    ]


def _controllers(controllers: Controllers) -> str:
    if controllers.left == controllers.right:
        return f"{controllers.left}, both ports"
    return f"{controllers.left} left, {controllers.right} right"


def _meaning(env_id: str) -> dict[str, Any]:
    """What `registration.explain` says, as data."""
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
