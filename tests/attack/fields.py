"""Tasks at the ends of their fields' ranges, and in all modes of all games, in vectors beside single environments."""

import random
from itertools import combinations
from typing import Any

import numpy as np
from field_values import DRAWN, end, seconds_of_noop, seconds_of_step, task_with, value_of
from lane_oracle import Lanes

from atari.task import Task
from attack.task_doors import any_game

SEEDS = 2**32
MODES = ("NextStep", "SameStep", "Disabled")
PAIRS = tuple(combinations(DRAWN, 2))
"""Every pair of fields: a seed takes the next one."""

OWN = ("mode", "difficulty", "interventions")
"""Fields in which the lanes of a vector may differ beside the game."""

BUDGET = 0.4
"""The seconds that one play may take on an idle machine, by `seconds_of_step`: it limits the number of steps, not the values."""


def attack(seed: int) -> None:
    """Play a task with two fields at their ends, and a vector of several games and modes."""
    source = random.Random(seed)
    pair = PAIRS[seed % len(PAIRS)]
    game = any_game(source)
    if task := task_with(source, game, {name: value_of(source, name, game, end) for name in pair}):
        play(source, [task], " and ".join(pair))
    if (task := task_with(source, any_game(source), {}, source.choice((0.1, 0.3)))) is not None:
        play(source, lanes_of(source, task), "several games and modes")


def lanes_of(source: random.Random, task: Task) -> list[Task]:
    """The task, and the same with other games, modes and difficulties."""
    lanes = [task]
    most = int(BUDGET / 3 / seconds_of_step(task))  # lanes for which three steps stay within the budget
    for game in (any_game(source) for _ in range(min(source.choice((0, 3, 7)), most))):
        own = {name: value_of(source, name, game) for name in OWN}
        try:
            lane = Task(game.id, **{**{name: getattr(task, name) for name in DRAWN}, **own})
        except ValueError:  # the game lacks an action, or rows of an image
            continue
        alike = {*task.differences(lane)} <= {"game", "rules", *OWN}
        if alike and (task.img_height is not None or lane.definition.screen.shape == task.definition.screen.shape):
            lanes.append(lane)
    return lanes


def play(source: random.Random, tasks: list[Task], what: str) -> None:
    """Play tasks within the budget, with resets of all kinds and snapshots in between."""
    costly = seconds_of_noop(tasks[0]) * tasks[0].noops[1] * len(tasks) > BUDGET / 4
    mode = source.choice(MODES[:1] if costly else MODES)  # of costly tasks, only resets with chosen seeds are played
    lanes = Lanes(tasks, mode, num_threads=source.choice((1, 2)))
    try:
        steps = int(BUDGET / len(tasks) / seconds_of_step(tasks[0], resets=not costly))
        generator = np.random.default_rng(source.randrange(SEEDS))
        (short if costly else whole)(source, lanes, generator, max(3, min(50, steps)))
    except AssertionError as error:
        shown = "; ".join(map(repr, tasks))
        raise AssertionError(f"{what}, {mode}: {error}\n{shown}") from None
    finally:
        lanes.close()


def short(source: random.Random, lanes: Lanes, generator: np.random.Generator, steps: int) -> None:
    """A reset with seeds that draw few no-ops, and steps until an episode ends."""
    seeds = [seed_of_few(source, lane.single, lane.task) for lane in lanes.lanes]
    if None in seeds:
        return
    lanes.reset(seeds)
    for _ in range(steps):
        lanes.step(lanes.sample(generator))
        if lanes.done:
            return


def seed_of_few(source: random.Random, single: Any, task: Task) -> int | None:
    """A seed for which an environment draws no-ops within the budget; None if none was found."""
    for _ in range(2000):
        seed = source.randrange(SEEDS)
        driver = single.unwrapped.driver
        driver.seed_game(seed)
        if seconds_of_noop(task) * driver.draw(task.noops[0], task.noops[1] + 1) < BUDGET:
            return seed
    return None


def whole(source: random.Random, lanes: Lanes, generator: np.random.Generator, steps: int) -> None:
    """Steps with resets, masked ones too, and snapshots to which some lanes return."""
    count, saved = len(lanes.lanes), False
    lanes.reset([source.randrange(SEEDS) for _ in range(count)])
    for _ in range(steps):
        match source.randrange(16):
            case 0:
                options = {"new_game": True} if source.random() < 0.5 else {}
                mask = [source.random() < 0.5 for _ in range(count)] if source.random() < 0.8 else None
                lanes.reset(seeds_of(source, count if mask is None else sum(mask)), mask, **options)
            case 1:
                lanes.save()
                saved = True
            case 2 if saved:
                lanes.restore(source.sample(range(count), source.randint(1, count)))
            case 3:
                lanes.observe()
            case _:
                lanes.step(lanes.sample(generator))


def seeds_of(source: random.Random, count: int) -> Any:
    """A seed in one of the forms that `reset` takes, for so many lanes."""
    each = [source.choice((source.randrange(SEEDS), source.randrange(100), 0, SEEDS - 1)) for _ in range(count)]
    some = [seed if source.random() < 0.5 else None for seed in each]
    signed = np.array([-1 if seed is None else seed for seed in some], np.int64)
    return source.choice(
        (None, source.choice((0, SEEDS - 1, source.randrange(SEEDS))), each, some, signed, np.array(each, np.uint64))
    )
