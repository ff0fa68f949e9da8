"""Images with other axes or as float32: a vector's equal those of the usual form."""

from functools import partial
from typing import Any

import numpy as np
import pytest
import vector_tools

import atari
from atari.task.fields import CHECKS
from atari.testing.contract import difference

make = partial(vector_tools.make, "breakout", 2)


def reference(observation: Any, channels_last: bool, dtype: str) -> Any:
    """The observation in a layout, computed the slow way."""
    if isinstance(observation, dict):
        return {name: reference(part, channels_last, dtype) for name, part in observation.items()}
    if channels_last and observation.ndim > 2:
        observation = np.stack([np.concatenate([np.atleast_3d(f) for f in row], -1) for row in observation])
    return observation.astype(dtype)


def assert_equal(one: Any, other: Any) -> None:
    assert difference(other, one, "observation") is None


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


def test_snapshots_are_the_same() -> None:
    envs, plain = make(channels_last=True, dtype="float32"), make()
    plain.reset(seed=1)
    envs.reset(seed=0)
    envs.restore(None, plain.snapshot())
    assert_equal(envs.observe()[0], reference(plain.observe()[0], True, "float32"))


@pytest.mark.parametrize("dtype", ["float64", "int8", None, np.int64, "colour"])
def test_wrong_dtypes(dtype: Any) -> None:
    with pytest.raises(TypeError if dtype == "colour" else ValueError, match="'uint8' or 'float32'"):
        make(dtype=dtype)


def test_out_is_filled_as_the_engine_writes() -> None:
    envs = make(channels_last=True)
    envs.reset(seed=0)
    with pytest.raises(ValueError, match="channels_last"):
        envs.step(np.zeros(2, int), out=np.empty((2, 84, 84, 4), np.uint8))
    envs.step(np.zeros(2, int))


def test_the_widths_are_those_of_the_field() -> None:
    width = CHECKS["img_width"].check
    for wrong in (width.low - 1, width.high + 1):
        with pytest.raises(ValueError, match="img_width must be within 1"):
            atari.AtariVectorEnv("pong", 1, img_width=wrong)
    assert atari.AtariVectorEnv("pong", 1, img_width=width.low).reset(seed=0)[0].shape == (1, 4, 84, width.low)
