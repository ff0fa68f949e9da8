"""`channels_last` and `dtype`: the same observations with other axes, or as float32."""

from typing import Any

import numpy as np
import pytest

import atari


def make(**options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", 2, num_threads=1, **options)


def reference(observation: Any, channels_last: bool, dtype: str) -> Any:
    """The observation in a layout, computed the slow way."""
    if isinstance(observation, dict):
        return {name: reference(part, channels_last, dtype) for name, part in observation.items()}
    if channels_last and observation.ndim > 2:
        observation = np.stack([np.concatenate([np.atleast_3d(f) for f in row], -1) for row in observation])
    return observation.astype(dtype)


def assert_equal(one: Any, other: Any) -> None:
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            assert_equal(one[name], other[name])
    else:
        assert one.dtype == other.dtype
        assert np.array_equal(one, other)


@pytest.mark.parametrize("obs_type", ["grayscale", "rgb", "ram", "dict"])
@pytest.mark.parametrize("channels_last", [False, True])
@pytest.mark.parametrize("dtype", ["uint8", "float32"])
def test_values(obs_type: str, channels_last: bool, dtype: str) -> None:
    if obs_type == "ram" and channels_last:
        with pytest.raises(ValueError, match="ram"):
            make(obs_type=obs_type, channels_last=True)
        return
    common = {"obs_type": obs_type, "autoreset_mode": "SameStep", "max_num_frames_per_episode": 12}
    envs, plain = make(**common, channels_last=channels_last, dtype=dtype), make(**common)
    observation, _ = envs.reset(seed=3)
    expected, _ = plain.reset(seed=3)
    ends = 0
    for _ in range(5):
        assert_equal(observation, reference(expected, channels_last, dtype))
        assert observation in envs.observation_space
        observation, *_, info = envs.step(np.array([1, 2]))
        expected, *_, other = plain.step(np.array([1, 2]))
        assert ("final_obs" in info) == ("final_obs" in other)
        if "final_obs" in info:
            ends += 1
            assert_equal(info["final_obs"], reference(other["final_obs"], channels_last, dtype))
    assert ends == 1


def test_shapes_and_copies() -> None:
    gray, rgb = make(channels_last=True), make(channels_last=True, obs_type="rgb", stack_num=1)
    assert gray.single_observation_space.shape == (84, 84, 4)
    assert rgb.single_observation_space.shape == (84, 84, 3)
    assert gray.reset(seed=0)[0].base is not None  # a view


def test_observations_stay_as_they_are() -> None:
    envs = make(channels_last=True)
    observation, _ = envs.reset(seed=0)
    kept = observation.copy()
    for _ in range(5):
        envs.step(np.array([1, 2]))
    assert np.array_equal(observation, kept)


def test_snapshots_are_the_same() -> None:
    envs, plain = make(channels_last=True, dtype="float32"), make()
    plain.reset(seed=1)
    envs.reset(seed=0)
    envs.restore(None, plain.snapshot())
    assert_equal(envs.observe()[0], reference(plain.observe()[0], True, "float32"))


@pytest.mark.parametrize("dtype", ["float64", "int8", None, np.int64])
def test_wrong_dtypes(dtype: Any) -> None:
    with pytest.raises(ValueError, match="'uint8' or 'float32'"):
        make(dtype=dtype)


def test_what_is_no_dtype() -> None:
    with pytest.raises(TypeError, match="'uint8' or 'float32'"):
        make(dtype="colour")


def test_out_is_filled_as_the_engine_writes() -> None:
    envs = make(channels_last=True)
    envs.reset(seed=0)
    with pytest.raises(ValueError, match="channels_last"):
        envs.step(np.zeros(2, int), out=np.empty((2, 84, 84, 4), np.uint8))
    envs.step(np.zeros(2, int))
