"""Observations are lent without a copy: their memory is reused only after the last array over it is gone."""

import gc

import numpy as np

import atari


def test_a_view_outlives_the_environment() -> None:
    envs = atari.AtariVectorEnv("pong", 2, num_threads=1)
    observation, _ = envs.reset(seed=1)
    view, expected = observation[1, 3:], observation[1, 3:].copy()
    del observation
    for _ in range(4):
        envs.step(np.zeros(2, np.int64))
    envs.close()
    del envs
    gc.collect()
    assert np.array_equal(view, expected)


def test_memory_is_used_again() -> None:
    """A loop that drops its observations uses two buffers; a view of an observation keeps its buffer from reuse."""
    envs = atari.AtariVectorEnv("pong", 1, num_threads=1)
    envs.reset(seed=0)

    def address() -> int:
        return int(envs.step(np.zeros(1, np.int64))[0].ctypes.data)

    assert len({address() for _ in range(6)}) <= 2
    observation = envs.step(np.zeros(1, np.int64))[0]
    view = observation[0]
    del observation
    assert view.ctypes.data not in {address() for _ in range(6)}


def test_parts_of_a_dict_are_lent_alike() -> None:
    envs = atari.AtariVectorEnv("pong", 1, num_threads=1, obs_type="dict", autoreset_mode="SameStep")
    ram = envs.reset(seed=0)[0]["ram"]
    kept = ram.copy()
    for _ in range(4):
        envs.step(np.zeros(1, np.int64))
    assert np.array_equal(ram, kept)
    assert ram.flags.writeable
