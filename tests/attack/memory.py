"""Allocations that fail: the address space is limited to little more than what is in use."""

import random
import resource
from pathlib import Path

import numpy as np

import atari
from attack.findings import attempt


def attack(seed: int) -> None:
    """Make, play and save environments until memory ends; MemoryError is allowed, an abort is not."""
    source = random.Random(seed)
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + source.choice((0, 100_000, 1 << 20, 4 << 20, 30 << 20))
    env = atari.AtariEnv("pong")
    resource.setrlimit(resource.RLIMIT_AS, (limit, before[1]))
    try:
        for _ in range(20):
            attempt(lambda: env.reset(seed=1))
            attempt(lambda: env.step(0))
            attempt(lambda: env.restore(env.snapshot()))
            vector = attempt(lambda: make(source, source.choice((1, 8, 64))))
            if vector is not None:
                attempt(lambda vector=vector: vector.step(np.zeros(vector.num_envs, np.int64)))
                attempt(vector.close)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def make(source: random.Random, count: int) -> atari.AtariVectorEnv:
    """A vector of up to four threads that has played."""
    game = source.choice(("pong", "qbert"))
    vector = atari.AtariVectorEnv(game, count, num_threads=source.choice((1, 2, 4)), grayscale=source.random() < 0.7)
    vector.reset(seed=0)
    vector.step(np.zeros(count, np.int64))
    return vector
