"""`atari info`: the facts of a game."""

import argparse
from typing import TYPE_CHECKING, Any

from atari import registration
from atari.cli.arguments import add_command, find_game
from atari.cli.output import print_json, to_json_types
from atari.games.game import Controllers, Game
from atari.games.multiplayer import Multiplayer
from atari.games.rules import Rules

if TYPE_CHECKING:
    from atari.cli.arguments import Commands


def register(commands: "Commands") -> None:
    """Add `atari info`."""
    parser = add_command(commands, "info", _info, "show the facts of a game: actions, modes, rules, ROM, IDs")
    parser.add_argument("game", metavar="GAME", help="a game, such as breakout, or an ID, such as Pong-v4")


def _info(args: argparse.Namespace) -> int:
    game = find_game(args.game, playable=False)
    ids = [family.id(game.id) for family in registration.FAMILIES if game.id in family.games()]
    print_json({**to_json_types(game), "ids": ids}) if args.json else print(_description(game, ids))
    return 0


def _description(game: Game, ids: list[str]) -> str:
    screen, rom = game.screen, game.rom
    facts: list[tuple[str, list[Any]]] = [
        ("players", [game.players]),
        ("screen", [f"{screen.width} columns, {screen.height} rows, {screen.format}"]),
        ("controllers", [_controllers(game.controllers)]),
        *(_settings(game) if game.rules else []),
        (
            "rules",
            _rules(game.rules) if game.rules else ["none for a single player, so there is no environment of one"],
        ),
        *(_multiplayer(game.multiplayer) if game.multiplayer else []),
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
    """Return actions, modes and difficulties."""
    names = " ".join(action.name for action in game.minimal_actions)
    return [
        ("actions", [f"{len(game.minimal_actions)} of {len(game.legal_actions)}: {names}"]),
        ("starts with", [" ".join(action.name for action in game.starting_actions) or "no action"]),
        ("modes", [f"{', '.join(map(str, game.modes))} (default {game.default_mode})"]),
        ("difficulties", [", ".join(map(str, game.difficulties))]),
    ]


def _multiplayer(rules: Multiplayer) -> list[tuple[str, list[Any]]]:
    """Return the modes of several players, by number of players."""
    names = " ".join(action.name for action in rules.minimal_actions)
    modes = [f"{players} players: modes {', '.join(map(str, modes))}" for players, modes in rules.modes.items()]
    return [("multiplayer", [*modes, f"actions of each: {names}"])]


def _rules(rules: Rules) -> list[str]:
    """Return the values at a reset, and the expressions evaluated on RAM after each frame."""
    at_reset = {"lives": rules.lives_initial, **rules.state}
    return [
        "at reset: " + ", ".join(f"{name} = {value}" for name, value in at_reset.items()),
        *(f"{name} = {expression}" for name, expression in rules.step),
    ]


def _controllers(controllers: Controllers) -> str:
    if controllers.left == controllers.right:
        return f"{controllers.left}, both ports"
    return f"{controllers.left} left, {controllers.right} right"
