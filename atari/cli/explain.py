"""`atari explain`: the task of an environment ID, a game or a task file, with options."""

import argparse
import json
from typing import Any

from atari.cli.arguments import GAME_HELP, Commands, add_command
from atari.cli.printing import print_json
from atari.observations.settings import observation_space
from atari.registry import registration
from atari.task import Task, env_ids
from atari.task.arguments import add_task, given_options, task_of


def register(commands: Commands) -> None:
    """Add `atari explain`."""
    parser = add_command(commands, "explain", _explain, "explain what an ID, a game or a task plays, with options")
    parser.add_argument("game", metavar="GAME", help=GAME_HELP)
    add_task(parser)


def _explain(args: argparse.Namespace) -> int:
    task = task_of(args)
    env_id = args.game.removeprefix(env_ids.MODULE_PREFIX)
    if not (given_options(args) or args.preset or args.print_task) and env_id in env_ids.ids():
        print_json(_facts(env_id, task)) if args.json else print(registration.explain(args.game))
        return 0
    if args.json:
        print_json(json.loads(task.to_json()) if args.print_task else {"id": None, **_described(task)})
        return 0
    print(task)
    if task.definition.file is not None and not args.print_task:
        stem = env_ids.stem(task.game)
        print(f"  IDs           {stem}-v5 and {stem}-ram-v5, after atari.register_game({args.game!r})")
    return 0


def _facts(env_id: str, task: Task) -> dict[str, Any]:
    """The facts that `registration.explain` prints, as data."""
    known = {other.id(task.game): other.options(task.game) for other in env_ids.FAMILIES if task.game in other.games()}
    return {"id": env_id, "options": known.pop(env_id), **_described(task), "siblings": known}


def _described(task: Task) -> dict[str, Any]:
    game = task.definition
    own = {} if game.file is None else {"ids": [f"{env_ids.stem(game.id)}{suffix}-v5" for suffix in ("", "-ram")]}
    return {
        "title": game.title,
        **own,
        "task": json.loads(task.to_json()),
        "observation": {"shape": _shape(task), "dtype": "uint8"},
        "actions": task.action_set,
        "modes": game.modes,
        "default_mode": game.default_mode,
        "difficulties": game.difficulties,
    }


def _shape(task: Task) -> tuple[int, ...] | None:
    """The shape of observations; None for several arrays."""
    if not task.kind.image:
        return (128,)
    return None if task.sound_obs else observation_space(task).shape
