"""`TorchEnvs`: the same steps with tensors."""

from typing import Any

import numpy as np
import pytest

import atari

pytestmark = pytest.mark.peers
torch = pytest.importorskip("torch", reason="needs PyTorch, which scripts/test --peers installs")

from atari.integrations.torch import TorchEnvs  # noqa: E402

CASES: dict[str, dict[str, Any]] = {
    "pixels": {},
    "RAM": {"obs_type": "ram", "autoreset_mode": "SameStep"},
    "both": {"obs_type": "dict", "autoreset_mode": "SameStep"},
    "float32": {"dtype": "float32", "channels_last": True, "autoreset_mode": "SameStep"},
}


def make(**options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", 3, max_num_frames_per_episode=60, **options)


def assert_same(tensors: Any, arrays: Any, name: str = "") -> None:
    if isinstance(arrays, dict):
        assert set(tensors) == set(arrays)
        for key, array in arrays.items():
            if key == "t":  # seconds
                continue
            assert_same(tensors[key], array, f"{name}.{key}")
    else:
        assert isinstance(tensors, torch.Tensor), name
        np.testing.assert_array_equal(tensors.numpy(), arrays, name)
        assert tensors.numpy().dtype == arrays.dtype, name


def staged(envs: atari.AtariVectorEnv) -> Any:
    """The view as for another device, with copies through two buffers, to the CPU."""
    from atari.integrations import torch as module

    view = TorchEnvs(envs)
    view._copies = module._Copies(torch.device("cpu"))
    view._takes_out = envs._options.layout.is_engines
    return view


def test_a_game_instead_of_environments() -> None:
    task = atari.Task.of("ALE/Pong-v5", obs_type="ram")
    for made in (TorchEnvs(task, num_envs=2), TorchEnvs("ALE/Pong-v5", num_envs=2, obs_type="ram")):
        assert made.task == task == made.envs.task
        assert made.reset(seed=0)[0].shape == (2, 128)
    with pytest.raises(TypeError, match="num_envs is an option of new environments, and these exist"):
        TorchEnvs(made.envs, num_envs=2)


@pytest.mark.parametrize("view", [TorchEnvs, staged], ids=["shared", "staged"])
@pytest.mark.parametrize("case", CASES)
def test_steps_are_the_same(case: str, view: Any) -> None:
    envs, twin = view(make(**CASES[case])), make(**CASES[case])
    kept = [(envs.reset(seed=0), twin.reset(seed=0))]
    for step in range(60):
        action = torch.full((3,), step % 4)
        kept.append((envs.step(action), twin.step(action.numpy())))
    for results, expected in kept:  # also after later steps
        for tensors, arrays in zip(results, expected, strict=True):
            assert_same(tensors, arrays)


def test_on_the_cpu_the_memory_is_shared() -> None:
    envs = make()
    view = TorchEnvs(envs)
    view.reset(seed=0)
    view.send(torch.zeros(3, dtype=torch.int64))
    observation, *_ = view.recv()
    address = observation.data_ptr()
    assert address in {buffer._observation[""].ctypes.data for buffer in envs._buffers}


@pytest.mark.parametrize("dtype", [torch.uint8, torch.int32, torch.int64])
def test_actions_of_every_integer_dtype(dtype: Any) -> None:
    view = TorchEnvs(make(obs_type="ram"))
    view.reset(seed=0)
    view.step(torch.ones(3, dtype=dtype))
    with pytest.raises(TypeError, match="must be integers"):
        view.step(torch.ones(3))
    with pytest.raises(ValueError, match="shape"):
        view.step(torch.ones(4, dtype=dtype))


def test_a_mask_of_resets_may_be_a_tensor() -> None:
    envs = make(obs_type="ram", autoreset_mode="Disabled")
    view = TorchEnvs(envs)
    view.reset(seed=0)
    for _ in range(5):
        _, _, _, _, info = view.step(torch.zeros(3, dtype=torch.int64))
    _, after = view.reset(options={"reset_mask": torch.tensor([True, False, True])})
    assert after["episode_frame_number"][1] == info["episode_frame_number"][1]
    assert after["episode_frame_number"][0] < info["episode_frame_number"][0]
