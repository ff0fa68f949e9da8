"""Functions that write into arrays of the caller: a core's readings, and batches of a replay memory.

Each writes into arrays between guard bytes, and once into arrays of its own; both must be equal. `sizes` does the same
with the observations of vectors.
"""

import random
from dataclasses import fields
from functools import partial
from typing import Any

import numpy as np
from guarded import Guards
from memory_cases import play, random_case

import atari
from atari.games.catalog import playable_ids
from atari.learning.memory.batches import make_batch

READINGS = ("ram", "screen", "screen_rgb", "screen_grayscale", "audio")


def attack(seed: int) -> None:
    source = random.Random(seed)
    attack_readings(source)
    attack_batches(source, seed)


def attack_readings(source: random.Random) -> None:
    """A core writes the same bytes into an array of the caller as into a new one."""
    env = atari.make(source.choice(playable_ids()), obs_type=source.choice(("rgb", "ram", "grayscale")))
    env.reset(seed=source.randrange(1000))
    core, guards = env.unwrapped.core, Guards(source)
    for _ in range(3):
        env.step(source.randrange(int(env.action_space.n)))
        for name in READINGS:
            read = getattr(core, name)
            expected = read()
            given = guards.array(expected.shape)
            assert read(out=given) is given
            assert np.array_equal(given, expected), name
            guards.check()
    env.close()


def attack_batches(source: random.Random, seed: int) -> None:
    """Two memories with equal steps and seeds draw equal batches, one of them into arrays of the caller."""
    case = random_case(source, seed)
    plain, guarded = play(case)[0], play(case)[0]
    if not plain.steps:
        return
    size, length = source.randint(1, 40), source.choice((0, 0, 1, 3))
    options: dict[str, Any] = {"stack_num": source.randint(1, case["stack"])}
    guards = Guards(source)
    share = not length and source.random() < 0.3
    out = make_batch(guarded._options, size, length, guarded._options.stacks(options["stack_num"]), guards.array, share)
    draw = "sample_sequences" if length else "sample"
    both = [
        partial(getattr(memory, draw), size, *((length,) if length else ()), **given)
        for memory, given in ((plain, options), (guarded, {"out": out}))
    ]
    for _ in range(4):
        try:
            expected = both[0]()
        except ValueError:  # no step can be drawn yet
            return
        given = both[1]()
        assert given is out
        guards.check()
        for field in fields(expected):
            if not field.name.startswith("_") and field.name not in ("frames", "num_envs"):
                assert np.array_equal(getattr(expected, field.name), getattr(given, field.name)), field.name
