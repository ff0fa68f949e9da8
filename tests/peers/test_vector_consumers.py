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


def test_tensors_that_are_held_stay():
    envs = atari.AtariVectorEnv("pong", 2)
    held = [atari.to_torch(envs.reset(seed=0)[0])]
    copies = [held[0].clone()]
    for _ in range(5):
        held.append(atari.to_torch(envs.step(np.array([2, 3]))[0]))
        copies.append(held[-1].clone())
    assert all(one.equal(copied) for one, copied in zip(held, copies, strict=True))


def test_memory_is_pinned_where_there_is_cuda():
    import torch

    array = np.arange(6, dtype=np.uint8)
    cuda = torch.cuda.is_available()
    tensor = atari.to_torch(array, pin_memory=True)
    assert tensor.is_pinned() == cuda
    assert (tensor.data_ptr() == array.ctypes.data) == (not cuda)
    device = "cuda" if cuda else "cpu"
    moved = atari.to_torch({"x": array}, device, pin_memory=True)["x"]
    assert moved.device.type == device
    assert moved.tolist() == [0, 1, 2, 3, 4, 5]


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
