"""The values of the fields of a `Task` that tests give: `CASES` has a row for each field, and `value_of` draws at random.

Random values come from the ranges of the fields' own checks, with their ends preferred, so that no range is written here.
"""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from atari.games.actions import PLAYER_ACTIONS
from atari.games.game import Game
from atari.games.interventions import load
from atari.task import Task
from atari.task.checks import NO_LIMIT, FrameSkip, OneOf, OrNone, Probability, Span, Whole, check_actions, check_bool
from atari.task.fields import CHECKS, DEFAULTS
from atari.task.rules import default_ineffective

Pick = Callable[[random.Random, int, int], int]
"""Draws an integer within low..high."""


@dataclass(frozen=True)
class Case:
    """A value of a field that acts.

    Attributes:
        value: a value other than the default, in Breakout unless the other fields name a game.
        needs: other fields, without which this one is refused or has no effect.
        seen: more fields, with which some hundred random steps show the effect.
        lacked_by: the environments that do not have the field: "one" player, "several" players, a "vector".
        several: the case of two players in Pong; None if it is the same.
        draw: draws a value where the field's check has no range.
    """

    value: Any
    needs: Mapping[str, Any] = field(default_factory=dict)
    seen: Mapping[str, Any] = field(default_factory=dict)
    lacked_by: str = ""
    several: "Case | None" = None
    draw: Callable[[random.Random, Game], Any] | None = None


def _reward(source: random.Random, game: Game) -> str | None:
    place = source.randrange(128)
    difference = f"{source.uniform(-1, 1):.2f} * (ram[{place}] - before.ram[{place}])"
    return source.choice((None, f"reward - {source.randint(0, 9)} * lives_lost", difference))


def _interventions(source: random.Random, game: Game) -> tuple[str, ...]:
    return tuple(source.sample(sorted(load(game)), source.randint(0, len(load(game)) > 0)))


_FIRE = {"fire": "after_noops"}
_LIVES = {"episodic_life": True}
_POOL = {"obs_type": "grayscale", "maxpool": True, "end_frames": "last"}
_PLAYERS = {"game": "pong", "players": 2}
_FROZEN = {"name": "frozen_ball", "description": "-", "source": "-", "writes": [{"to": "ball_x", "value": 80}]}

CASES: Mapping[str, Case] = {
    "game": Case("pong", several=Case("boxing"), draw=lambda source, game: game.id),
    "mode": Case(4, several=Case(10), draw=lambda source, game: source.choice(game.modes)),
    "difficulty": Case(1, draw=lambda source, game: source.choice(game.difficulties)),
    "players": Case(2, {"game": "pong"}, lacked_by="one", several=Case(4)),
    "actions": Case("full"),
    "continuous": Case(True, lacked_by="several"),
    "continuous_action_threshold": Case(0.75, {"continuous": True}, lacked_by="several"),
    "repeat_action_probability": Case(0.125),
    "frameskip": Case((2, 5)),
    "action_delay": Case((2, 7)),
    "interventions": Case(["strong_ball"], several=Case([_FROZEN]), draw=_interventions),
    "noops": Case((5, 9)),
    "fire": Case("after_noops", lacked_by="several"),
    "fire_counts": Case(True, {**_FIRE, "noops": (4, 4)}, lacked_by="several"),
    "third_action": Case(True, _FIRE, lacked_by="several"),
    "fire_unit": Case("skip", _FIRE, lacked_by="several"),
    "fire_again": Case(
        False,
        {"fire": "before_noops", "noops": (100, 100)},
        {"max_num_frames_per_episode": 90},
        lacked_by="several",
    ),
    "seeding": Case("ale", seen={"noops": (0, 30)}),
    "episodic_life": Case(True, seen=_FIRE, lacked_by="several"),
    "lives_unit": Case("skip", _LIVES, _FIRE, lacked_by="several"),
    "on_reset": Case("continue", _LIVES, _FIRE, lacked_by="several"),
    "last_life": Case(
        True, _LIVES, {"game": "frogger", "obs_type": "ram", "on_reset": "continue"}, lacked_by="several"
    ),
    "seamless_lives": Case(True, {**_LIVES, "on_reset": "continue"}, {**_FIRE, "stack_num": 4}, lacked_by="several"),
    "life_loss_info": Case(True, seen=_FIRE, lacked_by="several"),
    "max_num_frames_per_episode": Case(90),
    "max_frames": Case(90),
    "max_episode_steps": Case(20),
    "obs_type": Case("ram"),
    "img_height": Case(60, {"img_width": 84}, {"img_height": 84}),
    "img_width": Case(60, {"img_height": 84}, {"img_width": 84}),
    "stack_num": Case(2),
    "maxpool": Case(True, seen={"game": "ms_pacman"}, several=Case(True, seen={"game": "joust"})),
    "pool_rgb": Case(True, _POOL, {"game": "ms_pacman"}, several=Case(True, _POOL)),
    "padding": Case("reset", {"stack_num": 4}),
    "end_frames": Case(
        "baselines",
        seen={"max_num_frames_per_episode": 30},
        several=Case("gymnasium", seen={"max_num_frames_per_episode": 130}),
    ),
    "observation_delay": Case((2, 7)),
    "sound_obs": Case(True, lacked_by="vector several"),
    "agent_indicator": Case(True, _PLAYERS, lacked_by="one"),
    "reward": Case("reward - 5 * lives_lost", seen=_FIRE, lacked_by="several", draw=_reward),
    "reward_clipping": Case(True, seen={"game": "seaquest"}, several=Case(True, seen={"game": "joust"})),
    "zero_sum": Case(True, _PLAYERS, lacked_by="one"),
}
"""A row for each field but `rules` and `rom_md5`, which identify the game."""


def lacking(*kinds: str) -> tuple[str, ...]:
    """The fields that one of these kinds of environments does not have; see `Case.lacked_by`."""
    return tuple(name for name, case in CASES.items() if {*case.lacked_by.split()} & {*kinds})


def flags_of(name: str, value: Any) -> list[str]:
    """The flags of an option on a command line."""
    flag = f"--{name.replace('_', '-')}"
    if name == "interventions":
        return [f"--intervention={one['name'] if isinstance(one, Mapping) else one}" for one in value]
    if isinstance(value, bool):
        return [flag if value else flag.replace("--", "--no-", 1)]
    words = value if isinstance(value, (tuple, list)) else [value]
    return [f"{flag}={','.join('none' if word is None else str(word) for word in words)}"]


DRAWN = tuple(name for name in CASES if name != "game" and name not in lacking("one", "vector"))
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
    if draw := CASES[name].draw:
        return draw(source, game)
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
        case Span(each, or_number):
            low, high = sorted(pick(source, each.low, each.high) for _ in range(2))
            return (low, high) if not or_number or (low < high and source.random() < 0.3) else low
        case FrameSkip(each):
            low, high = sorted(pick(source, each.low, each.high) for _ in range(2))
            return (low, high) if low < high and source.random() < 0.3 else low
    if check is check_bool:
        return source.random() < 0.5
    assert check is check_actions, f"the case of {name} needs `draw`"
    names = [action.name for action in PLAYER_ACTIONS]
    return source.choice(("minimal", "full", tuple(source.sample(names, source.randint(1, len(names))))))


def task_of(source: random.Random, game: Game, fixed: Mapping[str, Any], changes: int) -> Task | None:
    """A task with `changes` fields drawn beside the `fixed` ones; None where the drawn fields contradict each other."""
    free = [name for name in CASES if name not in ("game", "players", *fixed)]
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
        default_ineffective(fields, given=())
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
