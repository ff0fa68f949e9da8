"""Random values of the fields of a `Task`, drawn from the ranges of the fields' own checks, with their ends preferred.

No range is written here: a field whose check changes is drawn from the new range.
"""

import random
from collections.abc import Callable, Mapping
from typing import Any

from atari.actions import PLAYER_ACTIONS
from atari.games.game import Game
from atari.task import Task
from atari.task.fields import (
    CHECKS,
    FrameSkip,
    Noops,
    OneOf,
    OrNone,
    Probability,
    Whole,
    check_actions,
    check_bool,
)
from atari.task.rules import settle
from atari.task.task import DEFAULTS


def whole(source: random.Random, low: int, high: int) -> int:
    """An integer within low..high: an end, a neighbour of one, a small one, or any; each magnitude is equally likely."""
    if source.random() < 0.5:
        return source.choice((low, low, high, high, min(low + 1, high), max(high - 1, low)))
    return low + int((high - low + 1) ** source.random()) - 1 if source.random() < 0.5 else source.randint(low, high)


def value_of(source: random.Random, name: str, game: Game) -> Any:
    """A value that the field `name` accepts in `game`."""
    return _drawn(source, name, CHECKS[name], game)


def _drawn(source: random.Random, name: str, check: Any, game: Game) -> Any:
    match check:
        case Whole(low, high):
            return whole(source, low, high)
        case Probability():
            return source.choice((check.low, check.high, source.uniform(check.low, check.high)))
        case OneOf(choices):
            return source.choice(choices)
        case OrNone(inner):
            return None if source.random() < 0.3 else _drawn(source, name, inner, game)
        case Noops(each):
            return tuple(sorted(whole(source, each.low, each.high) for _ in range(2)))
        case FrameSkip(each):
            low, high = sorted(whole(source, each.low, each.high) for _ in range(2))
            return (low, high) if low < high and source.random() < 0.3 else low
    if check is check_bool:
        return source.random() < 0.5
    if check is check_actions:
        names = [action.name for action in PLAYER_ACTIONS]
        return source.choice(("minimal", "full", tuple(source.sample(names, source.randint(1, len(names))))))
    return _OF_GAMES[name](source, game)


_OF_GAMES: Mapping[str, Callable[[random.Random, Game], Any]] = {
    "game": lambda source, game: game.id,
    "rules": lambda source, game: None,
    "rom_md5": lambda source, game: None,
    "mode": lambda source, game: source.choice(game.modes),
    "difficulty": lambda source, game: source.choice(game.difficulties),
    "interventions": lambda source, game: (),
    "reward": lambda source, game: None,
}
"""The fields whose values depend on the game alone, and texts that have generators of their own."""


def task_of(source: random.Random, game: Game, fixed: Mapping[str, Any], changes: int) -> Task | None:
    """A task with `changes` fields drawn beside the `fixed` ones; None where the drawn fields contradict each other."""
    free = [name for name in CHECKS if name not in ("game", "players", *fixed)]
    drawn = {name: value_of(source, name, game) for name in source.sample(free, changes)}
    fields: dict[str, Any] = {**DEFAULTS, "game": game.id, **fixed, **drawn}
    if (fields["img_height"] is None) != (fields["img_width"] is None):
        for name in ("img_height", "img_width"):
            fields[name] = fields[name] or value_of(source, name, game) or 1
    fields["img_height"] = fields["img_height"] and min(fields["img_height"], game.screen.height)
    try:
        settle(fields, DEFAULTS, given=())
        return Task(**fields)
    except ValueError:
        return None
