"""Helpers of the tests of `AtariVectorEnv`: make one, play it, and note the results."""

from typing import Any

import numpy as np

import atari


def make(game: Any = "breakout", num_envs: int | None = 3, **options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv(game, num_envs, **{"num_threads": 2, **options})


def begun(game: Any = "breakout", num_envs: int | None = 3, seed: Any = None, **options: Any) -> atari.AtariVectorEnv:
    """One that has been reset."""
    envs = make(game, num_envs, **options)
    envs.reset(seed=seed)
    return envs


def as_bytes(observation: Any) -> bytes:
    """An observation, an array or a dict of arrays, as bytes."""
    parts = observation.values() if isinstance(observation, dict) else [observation]
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


def play(envs: atari.AtariVectorEnv, steps: int, seed: int) -> list[bytes]:
    """All arrays of some steps of random actions from the present state."""
    generator = np.random.default_rng(seed)
    results = []
    for _ in range(steps):
        actions = generator.integers(0, envs.single_action_space.n, envs.batch_size)  # type: ignore[attr-defined]
        *arrays, info = envs.step(actions)
        arrays += [info[name] for name in ("env_id", "lives", "frame_number", "episode_frame_number")]
        results.append(b"".join(array.tobytes() for array in arrays))
    return results
