"""The vector environment's arrays in PyTorch, and beside EnvPool's."""

import numpy as np
import pytest

import atari

pytestmark = pytest.mark.peers


def test_torch_sees_the_same_memory():
    import torch

    envs = atari.AtariVectorEnv("pong", 2, obs_type="dict")
    observation, _ = envs.reset(seed=0)
    tensors = atari.to_torch(observation)
    assert tensors["image"].dtype == torch.uint8
    assert tensors["image"].data_ptr() == observation["image"].ctypes.data
    assert np.array_equal(tensors["ram"].numpy(), observation["ram"])
    observation["image"][0, 0] = 9
    assert (tensors["image"][0, 0] == 9).all()


def test_a_step_writes_into_a_tensor():
    import torch

    envs = atari.AtariVectorEnv("pong", 2)
    envs.reset(seed=0)
    memory = torch.zeros((4, 2, 4, 84, 84), dtype=torch.uint8)
    for place in memory:
        observation, reward, *_ = envs.step(np.zeros(2, int), out=place.numpy())
        assert np.array_equal(place.numpy(), observation)
        assert atari.to_torch([reward])[0].shape == (2,)
    assert memory.any()
