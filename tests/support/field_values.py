"""Random values of the fields of a `Task`, drawn from the ranges of the fields' own checks, with their ends preferred.

No range is written here: a field whose check changes is drawn from the new range.
"""

import random
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from atari.actions import PLAYER_ACTIONS
from atari.games.game import Game
from atari.games.interventions import load
from atari.task import Task
from atari.task.checks import NO_LIMIT, FrameSkip, Noops, OneOf, OrNone, Probability, Whole, check_actions, check_bool
from atari.task.fields import CHECKS, DEFAULTS
from atari.task.rules import settle

Pick = Callable[[random.Random, int, int], int]
"""Draws an integer within low..high."""

OF_SEVERAL = ("sound_obs", "agent_indicator", "zero_sum")
"""Fields that a vector of one player does not have."""

DRAWN = tuple(name for name in CHECKS if name not in ("game", "rules", "rom_md5", "players", *OF_SEVERAL))
"""The fields of a task of one player that a vector plays, too."""


def whole(source: random.Random, low: int, high: int) -> int:
    """An integer within low..high: an end, a neighbour of one, a small one, or any; each magnitude is equally likely."""
    if source.random() < 0.5:
        return source.choice((low, low, high, high, min(low + 1, high), max(high - 1, low)))
    return low + int((high - low + 1) ** source.random()) - 1 if source.random() < 0.5 else source.randint(low, high)


def end(source: random.Random, low: int, high: int) -> int:
    """An end of low..high."""
    return source.choice((low, high))


def small(source: random.Random, low: int, high: int) -> int:
    """An integer of at most 255 above low; each magnitude is equally likely."""
    return low + int(min(high - low + 1, 256) ** source.random()) - 1


def value_of(source: random.Random, name: str, game: Game, pick: Pick = whole) -> Any:
    """A value that the field `name` accepts in `game`; `pick` draws its numbers."""
    return _drawn(source, name, CHECKS[name], game, pick)


def _drawn(source: random.Random, name: str, check: Any, game: Game, pick: Pick) -> Any:
    match check:
        case Whole(low, high):
            return pick(source, low, high)
        case Probability():
            ends = check.low, check.high
            return source.choice(ends if pick is end else (*ends, source.uniform(*ends)))
        case OneOf(choices):
            return source.choice(choices)
        case OrNone(inner):
            return None if source.random() < 0.3 else _drawn(source, name, inner, game, pick)
        case Noops(each):
            return tuple(sorted(pick(source, each.low, each.high) for _ in range(2)))
        case FrameSkip(each):
            low, high = sorted(pick(source, each.low, each.high) for _ in range(2))
            return (low, high) if low < high and source.random() < 0.3 else low
    if check is check_bool:
        return source.random() < 0.5
    if check is check_actions:
        names = [action.name for action in PLAYER_ACTIONS]
        return source.choice(("minimal", "full", tuple(source.sample(names, source.randint(1, len(names))))))
    return _OF_GAMES[name](source, game)


def _reward(source: random.Random, game: Game) -> str | None:
    place = source.randrange(128)
    difference = f"{source.uniform(-1, 1):.2f} * (ram[{place}] - before.ram[{place}])"
    return source.choice((None, f"reward - {source.randint(0, 9)} * lives_lost", difference))


_OF_GAMES: Mapping[str, Callable[[random.Random, Game], Any]] = {
    "game": lambda source, game: game.id,
    "rules": lambda source, game: None,
    "rom_md5": lambda source, game: None,
    "mode": lambda source, game: source.choice(game.modes),
    "difficulty": lambda source, game: source.choice(game.difficulties),
    "interventions": lambda source, game: tuple(
        source.sample(sorted(load(game)), source.randint(0, len(load(game)) > 0))
    ),
    "reward": _reward,
}
"""The fields whose values depend on the game alone, and texts."""


def task_of(source: random.Random, game: Game, fixed: Mapping[str, Any], changes: int) -> Task | None:
    """A task with `changes` fields drawn beside the `fixed` ones; None where the drawn fields contradict each other."""
    free = [name for name in CHECKS if name not in ("game", "players", *fixed)]
    drawn = {name: value_of(source, name, game) for name in source.sample(free, changes)}
    return settled(source, game, {**fixed, **drawn})


def task_with(source: random.Random, game: Game, wanted: Mapping[str, Any], chance: float = 0.3) -> Task | None:
    """A task in which the fields of `wanted` have these values, and an effect beside the others.

    Each other field is drawn with this chance, with small numbers. None if no such task was found.
    """
    for _ in range(100):
        others = {
            name: value_of(source, name, game, small)
            for name in DRAWN
            if name not in wanted and source.random() < chance
        }
        task = settled(source, game, {**others, **wanted})
        if task is not None and all(_has(task, name, value) for name, value in wanted.items()):
            return task
    return None


def _has(task: Task, name: str, value: Any) -> bool:
    """Whether a field has this value; some have another form in a task."""
    found = getattr(task, name)
    return name in ("mode", "difficulty", "actions", "interventions", "reward") or bool(
        found == value or (name == "continuous_action_threshold" and np.float32(found) == np.float32(value))
    )


def settled(source: random.Random, game: Game, drawn: Mapping[str, Any]) -> Task | None:
    """The task of drawn fields, without those that have no effect; None where they contradict each other."""
    fields: dict[str, Any] = {**DEFAULTS, "game": game.id, **drawn}
    if (fields["img_height"] is None) != (fields["img_width"] is None):
        for name in ("img_height", "img_width"):
            fields[name] = fields[name] or value_of(source, name, game) or 1
    fields["img_height"] = fields["img_height"] and min(fields["img_height"], game.screen.height)
    try:
        settle(fields, DEFAULTS, given=())
        return Task(**fields)
    except ValueError:
        return None


def seconds_of_noop(task: Task) -> float:
    """About the seconds that a no-op of a reset takes in a vector and in a single environment, on an idle machine."""
    return 4e-5 + _RESET_SECONDS / (task.max_num_frames_per_episode or NO_LIMIT)


_RESET_SECONDS = 8e-3


def seconds_of_step(task: Task, resets: bool = True) -> float:
    """About the seconds that a step of a task takes in a vector and in a single environment, on an idle machine.

    Args:
        task: the task.
        resets: whether to count the resets, which follow a step so often as the limits of the task make them.
    """
    rows, columns = task.definition.screen.shape
    pixels = (task.img_height or rows) * (task.img_width or columns) * (3 if "rgb" in task.obs_type else 1)
    observation = 1.2e-8 * (task.stack_num or 1) * (128 if task.obs_type == "ram" else pixels)
    frames = task.frames[1]
    limits = (task.max_num_frames_per_episode, task.max_frames, (task.max_episode_steps or NO_LIMIT) * frames)
    often = min(1.0, 0.1 + frames / min(limit or NO_LIMIT for limit in limits)) if resets else 0.0
    return (
        2e-4
        + 2e-5 * frames
        + observation
        + often * (_RESET_SECONDS + observation + seconds_of_noop(task) * task.noops[1])
    )
