"""Games of two to four players on the command line: `atari play --players` and `atari record --players`."""

import argparse
from collections.abc import Callable
from functools import partial

from atari.games.game import Game
from atari.games.pettingzoo import find_environment
from atari.games.players import pettingzoo_options, rules_of
from atari.play.multiplayer_session import MultiplayerSession
from atari.task import Task
from atari.task.arguments import given_options, read_game, task_of
from atari.task.task import BY_FRAME, look_up

_OBEYED = ("players", "mode", "difficulty", "obs_type")


def is_match(args: argparse.Namespace) -> bool:
    """Whether the flags or a task select several players."""
    game = read_game(args.game)
    players: int = getattr(args, "players", game.players if isinstance(game, Task) else 1)
    return players > 1


def match_task(args: argparse.Namespace) -> Task:
    """The task for several players. A name of PettingZoo's chooses the mode, unless there is a flag.

    Raises:
        ValueError: there is no such game or mode, the number of players is wrong, or there is a field that sessions
            for several players do not honour.
    """
    given, name = given_options(args), args.game
    environment = None if name.endswith((".toml", ".json")) else find_environment(name)
    found = look_up(read_game(name) if environment is None else environment.game)
    if environment is not None:
        chosen = pettingzoo_options(
            environment, {field: given[field] for field in ("mode", "players") if field in given}
        )
        args.mode, args.players = chosen["mode"], chosen["players"]
    elif "players" not in given and isinstance(found.game, Game):
        modes = rules_of(found.game).modes
        args.players = next((count for count in modes if getattr(args, "mode", None) in modes[count]), min(modes))
    args.fixed = {}
    task = task_of(args, found, base=BY_FRAME)
    fields = {field: getattr(task, field) for field in _OBEYED}
    plain = Task.of(task.definition, **{**BY_FRAME, **fields})
    wrong = {field: repr(value) for field, (value, _) in task.differences(plain).items()}
    for field, value in ({"presets": f"--preset {args.preset}"} if args.preset is not None else wrong).items():
        raise ValueError(
            f"games of several players are recorded and played without {field}, got {value}; leave it out "
            f"(accepted: {', '.join(_OBEYED)})"
        )
    return task


def make_match(
    args: argparse.Namespace, task: Task, option: str, names: list[str]
) -> Callable[..., MultiplayerSession]:
    """A function that makes the session of a task with its files.

    `names` are the policies, with --policy from player 1 on.

    Raises:
        ValueError: there is no such policy, or their number is wrong.
    """
    count = task.players
    first = 0 if option == "--policy" else 1
    if len(names) == 1 and option == "--policy":
        names = names * count
    if len(names) > count - first or (option == "--policy" and len(names) != count):
        often = f"once, or {count} times" if option == "--policy" else f"at most {count - first} times"
        raise ValueError(f"{args.game} has {count} players; give {option} {often}, got {len(names)}")
    policies = dict(zip(range(first, count), names, strict=False))
    return partial(
        MultiplayerSession,
        task.definition,
        rom=args.rom,
        players=count,
        mode=task.mode,
        difficulty=task.difficulty,
        seed=args.seed,
        policies=policies,
        obs_type=task.obs_type,  # type: ignore[arg-type]  # which it checks
    )
