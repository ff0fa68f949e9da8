"""Helpers of the tests of recordings: record a short game; a disk without space."""

import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gymnasium

import atari
from atari.recording import RecordReplay


def play(env: gymnasium.Env[Any, Any], steps: int, seed: int | None = 0) -> list[tuple[Any, ...]]:
    """Play at random and return the result of each step."""
    env.action_space.seed(0 if seed is None else seed)
    env.reset(seed=seed)
    results = []
    for _ in range(steps):
        result = env.step(env.action_space.sample())
        results.append(result)
        if result[2] or result[3]:
            env.reset()
    return results


def record(path: Path, game: str = "breakout", steps: int = 100, seed: int | None = 0, **options: Any) -> Path:
    """A replay of random play."""
    env = RecordReplay(atari.AtariEnv(game, **options), path)
    play(env, steps, seed)
    env.close()
    return path


@contextmanager
def full_disk(limit: int) -> Iterator[None]:
    """Let no file of this process grow beyond `limit` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
