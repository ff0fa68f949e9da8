"""One environment, one core and one vector used, saved and closed by several threads at the same time."""

import contextlib
import random
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

import atari
from attack.findings import ALLOWED


def attack(seed: int) -> None:
    """All threads must end; a call raises an allowed exception, or does its work."""
    source = random.Random(seed)
    sys.setswitchinterval(source.choice((1e-6, 1e-4, 5e-3)))
    env = atari.AtariEnv("breakout", obs_type="ram")
    vector = atari.AtariVectorEnv("breakout", 2, num_threads=source.choice((1, 2)), obs_type="ram")
    env.reset(seed=0), vector.reset(seed=0)
    saved, saved_lanes = env.snapshot(), vector.snapshot()
    actions = np.zeros(2, np.int64)
    calls: list[Any] = [
        lambda: env.step(0),
        lambda: env.step(0),
        lambda: env.reset(),
        lambda: env.restore(saved),
        lambda: env.snapshot(),
        lambda: env.core.screen(),
        lambda: vector.step(actions),
        lambda: vector.step(actions),
        lambda: vector.reset(),
        lambda: vector.snapshot(),
        lambda: vector.restore(None, saved_lanes),
        lambda: actions.fill(source.choice((0, 1, 3, 2**44, -1))),
    ]

    def work(number: int) -> None:
        chosen = random.Random(seed * 100 + number)
        for _ in range(60):
            with contextlib.suppress(*ALLOWED):
                chosen.choice(calls)()

    closing = threading.Timer(source.random() * 0.02, lambda: (env.close(), vector.close()))
    with ThreadPoolExecutor(4) as pool:
        closing.start()
        list(pool.map(work, range(4)))
    closing.join()
