"""`atari info`: what works here; the games or IDs; the facts of a game; what an ID, a task or a video plays."""

import argparse
import json
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from atari.base.text_table import fact_lines
from atari.base.typed_table import check_type
from atari.cli import installation
from atari.cli.arguments import GAME_HELP, Commands, add_command
from atari.cli.printing import print_json, print_table, to_json_types
from atari.env.settings import observation_space
from atari.games.catalog import games
from atari.games.game import Controllers, Game
from atari.games.interventions import load
from atari.games.manual import Manual
from atari.games.multiplayer import Multiplayer
from atari.games.pettingzoo import ENVIRONMENTS
from atari.games.rules import Rules
from atari.recording import video_facts
from atari.recording.video.formats import FORMATS
from atari.registry import registration
from atari.task import Task, env_ids
from atari.task.arguments import add_task, given_options, read_game, show_task, task_of
from atari.task.task import look_up


def register(commands: Commands) -> None:
    """Add `atari info`."""
    parser = add_command(
        commands, "info", _info, "say what works here, show the facts of a game, or explain what an ID or a task plays"
    )
    parser.add_argument(
        "game",
        metavar="GAME",
        nargs="?",
        help=f"{GAME_HELP}; or a video. A game alone shows its facts. An ID, a task, or a game with options of a task "
        "shows what is played, a video what was played (default: what works here and what is not installed)",
    )
    parser.add_argument("--games", action="store_true", help="list the games; with --players 2 or 4, those for several")
    parser.add_argument("--ids", action="store_true", help="list the IDs that gymnasium.make accepts, one a line")
    add_task(parser)


def _info(args: argparse.Namespace) -> int:
    options = {**given_options(args), **{name: True for name in ("preset", "print_task") if getattr(args, name)}}
    if args.game is None and not (args.games or args.ids or options):
        here = installation.facts()
        print_json(here) if args.json else print("\n".join(installation.lines(here)))
        return 0
    if args.game is None or args.games or args.ids:
        return _list(args, options)
    if Path(args.game).suffix.lower() in FORMATS:
        if options:
            raise ValueError("a video says what was played; leave the options of a task out")
        return _of_video(args)
    found = look_up(read_game(args.game))
    if options or not found.bare or found.environment is not None:
        return _of_task(args, task_of(args, found), not options)
    game = found.definition
    if args.json:
        own = {"manual": game.manual, "interventions": _interventions(game), "ids": _ids(game)}
        print_json({**to_json_types(game), **own})
    else:
        print(_description(game, args.game))
    return 0


def _list(args: argparse.Namespace, options: Mapping[str, Any]) -> int:
    """The IDs, the games for a number of players, or all games."""
    if args.ids and (args.games or args.game is not None or options):
        raise ValueError("--ids lists all IDs; leave GAME, --games and the options of a task out")
    if args.game is not None:
        raise ValueError(f"--games lists all games; leave {args.game} out")
    players = options.get("players")
    if options and (players is None or len(options) > 1):
        others = ", ".join(name for name in options if name != "players")
        raise ValueError(f"options of a task need GAME, got {others} without it; name the game")
    if players not in (None, 2, 4):
        raise ValueError(f"without GAME, --players lists the games of 2 or 4 players, got {players}")
    if args.ids:
        print_json([*env_ids.ids()]) if args.json else print("\n".join(env_ids.ids()))
    elif players is not None:
        rows = [*_multiplayer_rows(players)]
        names = ("environment", "game", "players", "actions")
        print_json([dict(zip(names, row, strict=True)) for row in rows]) if args.json else print_table([names, *rows])
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


def _of_task(args: argparse.Namespace, task: Task, unchanged: bool) -> int:
    """Explain the task of an ID, a task, or a game with options; `unchanged` is whether there are no options."""
    env_id = args.game.removeprefix(env_ids.MODULE_PREFIX)
    if args.print_task:
        show_task(args, task)
    elif unchanged and env_id in env_ids.ids():
        if not args.json:
            print(registration.explain(args.game))
            return 0
        families = [other for other in env_ids.FAMILIES if task.game in other.games()]
        known = {other.id(task.game): other.options(task.game) for other in families}
        print_json({"id": env_id, "options": known.pop(env_id), **_facts_of_task(task), "siblings": known})
    elif args.json:
        print_json({"id": None, **_facts_of_task(task)})
    else:
        print("\n".join([str(task), *_own_ids(task.definition, args.game)]))
    return 0


def _facts_of_task(task: Task) -> dict[str, Any]:
    game = task.definition
    return {
        "title": game.title,
        **({} if game.file is None else {"ids": _ids(game)}),
        "task": json.loads(task.to_json()),
        "observation": {"shape": None if task.sound_obs else observation_space(task).shape, "dtype": "uint8"},
        "actions": task.action_set,
        "modes": game.modes,
        "default_mode": game.default_mode,
        "difficulties": game.difficulties,
    }


def _ids(game: Game) -> list[str]:
    """The IDs of a game. `atari.register_game` registers the IDs of a game of the user's own."""
    if game.file is not None:
        return [f"{env_ids.stem(game.id)}{suffix}-v5" for suffix in ("", "-ram")]
    return [family.id(game.id) for family in env_ids.FAMILIES if game.id in family.games()]


def _own_ids(game: Game, file: str) -> list[str]:
    """The line about the IDs of a game of the user's own; none for a game of this package."""
    if game.file is None:
        return []
    return fact_lines("IDs", [f"{' and '.join(_ids(game))}, after atari.register_game({file!r})"])


def _of_video(args: argparse.Namespace) -> int:
    facts = video_facts(args.game)
    if args.json:
        print_json(facts)
        return 0
    print(f"{args.game}: written by {facts['package']}")
    for one in (facts, *check_type(facts.pop("beside", []), "beside", list)):
        print("\n".join(_played(check_type(one, "what was played", dict))))
    return 0


def _played(facts: Mapping[str, Any]) -> Iterator[str]:
    """The lines about one game of a video."""
    try:
        yield str(Task.from_json(json.dumps(facts["task"])))
    except (KeyError, TypeError, ValueError):  # the user's own game, or a game for several players
        yield json.dumps(facts.get("task", facts))
    if "name" in facts:
        yield from fact_lines("name", [facts["name"]])
    for name in ("switched_on", "core_seeds"):
        if name in facts:
            yield from fact_lines(name.replace("_", " "), [", ".join(map(str, check_type(facts[name], name, list)))])


def _description(game: Game, file: str) -> str:
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
        ("changes", _changes(game)),
        ("ROM", [f"{rom.size} bytes, {rom.cartridge}, MD5 {rom.md5}"]),
        ("notes", [*(game.manual.notes if game.manual else ()), *game.notes]),
        ("IDs", _ids(game) if game.file is None else []),
    ]
    lines = (line for name, values in facts for line in fact_lines(name, values))
    return "\n".join([f"{game.id}: {game.title}", *lines, *_own_ids(game, file)])


def _manual(manual: Manual) -> list[tuple[str, list[Any]]]:
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


def _interventions(game: Game) -> dict[str, str]:
    """Return what each intervention of the package changes, by name. A game of the user's own has none."""
    return {} if game.file else {name: one.description for name, one in load(game).items()}


def _changes(game: Game) -> list[str]:
    """Return a line on the use of interventions, then each of them with what it changes."""
    known = _interventions(game)
    if not known:
        return []
    width = max(map(len, known))
    lines = [f"{len(known)} interventions, such as `atari play {game.id} --intervention {next(iter(known))}`"]
    for name, text in known.items():
        lines += textwrap.wrap(f"{name:{width}}  {text}", 100, subsequent_indent=" " * (width + 2))
    return lines


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
