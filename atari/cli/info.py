"""`atari info`: the facts of a game."""

import argparse
import json
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from atari.base.json_text import check_kind
from atari.cli.arguments import GAME_HELP, Commands, add_command, find_game
from atari.cli.printing import print_json, to_json_types
from atari.games.game import Controllers, Game
from atari.games.manual import Manual
from atari.games.multiplayer import Multiplayer
from atari.games.rules import Rules
from atari.recording import video_facts
from atari.recording.video.formats import FORMATS
from atari.task import Task, env_ids


def register(commands: Commands) -> None:
    """Add `atari info`."""
    parser = add_command(
        commands, "info", _info, "show the facts of a game: what it is, actions, modes, rules, ROM, IDs"
    )
    parser.add_argument("game", metavar="GAME", help=f"{GAME_HELP}; or a video, which says what was played")


def _info(args: argparse.Namespace) -> int:
    if Path(args.game).suffix.lower() in FORMATS:
        return _of_video(args)
    game = find_game(args.game, playable=False)
    ids = [family.id(game.id) for family in env_ids.FAMILIES if game.id in family.games()]
    if args.json:
        print_json({**to_json_types(game), "manual": game.manual, "ids": ids})
    else:
        print(_description(game, ids))
    return 0


def _of_video(args: argparse.Namespace) -> int:
    facts = video_facts(args.game)
    if args.json:
        print_json(facts)
        return 0
    try:
        played = str(Task.from_json(json.dumps(facts["task"])))
    except (KeyError, TypeError, ValueError):  # the user's own game, or a game for several players
        played = json.dumps(facts.get("task", facts))
    print(f"{args.game}: written by {facts['package']}\n{played}")
    if "core_seeds" in facts:
        print(f"  {'core seeds':13} {', '.join(map(str, check_kind(facts['core_seeds'], 'core_seeds', list)))}")
    return 0


def _description(game: Game, ids: list[str]) -> str:
    screen, rom = game.screen, game.rom
    facts: list[tuple[str, list[Any]]] = [
        *(_manual(game.manual) if game.manual else []),
        ("players", [game.players]),
        ("screen", [f"{screen.width} columns, {screen.height} rows, {screen.format}"]),
        ("controllers", [_controllers(game.controllers)]),
        *(_settings(game) if game.rules else []),
        (
            "rules",
            _rules(game.rules) if game.rules else ["none for a single player, so there is no environment of one"],
        ),
        *(_multiplayer(game.multiplayer, game.manual) if game.multiplayer else []),
        ("RAM", [f"{len(game.ram_labels)} names for bytes of it (name:index)", *_labels(game)]),
        ("ROM", [f"{rom.size} bytes, {rom.cartridge}, MD5 {rom.md5}"]),
        ("notes", [*(game.manual.notes if game.manual else ()), *game.notes]),
        ("IDs", ids),
    ]
    lines = [f"{game.id}: {game.title}"]
    for name, values in facts:
        lines += [f"  {'' if i else name:12}  {value}" for i, value in enumerate(values)]
    return "\n".join(lines)


def _manual(manual: Manual) -> list[tuple[str, list[Any]]]:
    """Return the manual's texts about the game as a whole."""
    released = [str(fact) for fact in (manual.year, manual.maker) if fact is not None]
    texts = (("reward", manual.reward), ("lives", manual.lives), ("end", manual.end))
    return [
        ("released", [", ".join(released) or "not known"]),
        ("about", textwrap.wrap(manual.description, 100)),
        *((name, [text]) for name, text in texts if text),
    ]


def _meanings(meanings: Mapping[int, str]) -> list[str]:
    """Return lines of the form "number  meaning", with the numbers aligned to the right."""
    width = max((len(str(number)) for number in meanings), default=0)
    return [f"{number:{width}}  {text}" for number, text in meanings.items()]


def _settings(game: Game) -> list[tuple[str, list[Any]]]:
    """Return actions, modes and difficulties."""
    names = " ".join(action.name for action in game.minimal_actions)
    return [
        ("actions", [f"{len(game.minimal_actions)} of {len(game.legal_actions)}: {names}"]),
        ("starts with", [" ".join(action.name for action in game.starting_actions) or "no action"]),
        (
            "modes",
            [
                f"{', '.join(map(str, game.modes))} (default {game.default_mode})",
                *_meanings(game.manual.modes if game.manual else {}),
            ],
        ),
        (
            "difficulties",
            [", ".join(map(str, game.difficulties)), *_meanings(game.manual.difficulties if game.manual else {})],
        ),
    ]


def _multiplayer(rules: Multiplayer, manual: Manual | None) -> list[tuple[str, list[Any]]]:
    """Return the modes for several players, by number of players."""
    names = " ".join(action.name for action in rules.minimal_actions)
    modes = [f"{players} players: modes {', '.join(map(str, modes))}" for players, modes in rules.modes.items()]
    named = _meanings(manual.multiplayer_modes if manual else {})
    return [("multiplayer", [*modes, *named, f"actions of each: {names}"])]


def _labels(game: Game) -> list[str]:
    """Return the names of bytes with their indices, grouped by the kind of label."""
    kinds: dict[str, list[str]] = {}
    for label in game.ram_labels.values():
        kinds.setdefault(label.kind, []).append(f"{label.name}:{label.index}")
    return [
        line
        for kind, names in sorted(kinds.items())
        for line in textwrap.wrap(f"{kind}: {', '.join(names)}", 100, subsequent_indent="    ", break_on_hyphens=False)
    ]


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
