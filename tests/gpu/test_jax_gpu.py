"""`xla(envs)` on a GPU: compiled functions call back to the host."""

import numpy as np
import pytest

import atari
from atari.integrations.jax import xla

jax = pytest.importorskip("jax", reason="needs JAX with CUDA")
if jax.default_backend() != "gpu":
    pytest.skip("needs a GPU that JAX can use", allow_module_level=True)


@pytest.mark.parametrize("obs_type", ["grayscale", "ram", "dict"])
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
@pytest.mark.parametrize("apart", [False, True], ids=["step", "send and recv"])
@pytest.mark.parametrize("num_envs", [8, 128])  # XLA fuses slices with other functions if they are aligned
def test_a_scan_is_as_many_steps(num_envs: int, apart: bool, mode: str, obs_type: str) -> None:
    options = {"obs_type": obs_type, "autoreset_mode": mode, "max_num_frames_per_episode": 60}
    envs, twin = (atari.AtariVectorEnv("breakout", num_envs, **options) for _ in range(2))
    handle, recv, send, step = xla(envs)
    if apart:
        step = lambda handle, action: recv(send(handle, action))  # noqa: E731
    actions = np.random.default_rng(0).integers(4, size=(100, num_envs))
    for env in (envs, twin):
        env.reset(seed=0)
    _, results = jax.jit(lambda handle, actions: jax.lax.scan(step, handle, actions))(handle, actions)
    for row, action in enumerate(actions):
        observation, reward, terminated, truncated, _ = twin.step(action)
        parts = observation if isinstance(observation, dict) else {"": observation}
        got = results[0] if isinstance(observation, dict) else {"": results[0]}
        for name, part in parts.items():
            np.testing.assert_array_equal(got[name][row], part)
        for array, expected in zip(results[1:4], (reward, terminated, truncated), strict=True):
            np.testing.assert_array_equal(array[row], expected)


def test_observations_are_written_to_page_locked_memory() -> None:
    from atari.integrations.jax.callback import pinned_arrays

    assert pinned_arrays(jax.ShapeDtypeStruct((8, 4, 84, 84), np.uint8)) is not None
