"""Observations are lent without a copy: their memory is reused only after the last array over it is gone."""

import gc

import numpy as np
import pytest

import atari
import atari._emulator as _emulator
from atari.vector.results import Results


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

    addresses = [address() for _ in range(6)]
    assert len({*addresses}) == 2
    assert addresses[::2] == [addresses[0]] * 3
    observation = envs.step(np.zeros(1, np.int64))[0]
    view = observation[0]
    del observation
    assert view.ctypes.data not in {address() for _ in range(6)}


def test_arrays_of_the_user_take_turns() -> None:
    """`out` may be another array at each step, also while final observations are held."""
    options = {"num_threads": 1, "autoreset_mode": "SameStep", "episodic_life": True, "obs_type": "dict"}
    envs, others = (atari.AtariVectorEnv("breakout", 2, **options) for _ in range(2))
    envs.reset(seed=3)
    others.reset(seed=3)
    random = np.random.default_rng(0)
    held = []
    for _ in range(120):
        actions = random.integers(0, 4, 2)
        out = {"image": np.empty((2, 4, 84, 84), np.uint8), "ram": np.empty((2, 128), np.uint8)}
        found, wanted = envs.step(actions, out=out), others.step(actions)
        assert found[0]["image"] is out["image"]
        held.append((found, [np.array(part) for part in (wanted[0]["image"], wanted[0]["ram"], *wanted[1:4])]))
        if "final_obs" in wanted[4]:
            held[-1] = (found, [*held[-1][1], np.array(wanted[4]["final_obs"]["image"])])
    assert sum(len(parts) == 6 for _, parts in held) >= 3
    for (observation, *signals, info), parts in held:
        shown = [observation["image"], observation["ram"], *signals]
        shown += [info["final_obs"]["image"]] if "final_obs" in info else []
        assert all(np.array_equal(a, b) for a, b in zip(shown, parts, strict=True))


@pytest.mark.parametrize("players", [1, 2])
@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_the_engine_says_names_dtypes_and_shapes_of_its_arrays(players: int, mode: str) -> None:
    """Those of a batch, and those that compiled functions get: the same, with observations and without doubles."""
    envs = atari.AtariVectorEnv("pong", 3, obs_type="dict", autoreset_mode=mode, players=players)
    batch = Results(envs._engine, envs._options).batch
    each = (3,) if players == 1 else (3, 2)
    integers = {"reward": each, "game_reward": each, "lives": each, "env_id": (3,), "elapsed_step": (3,)}
    integers |= {"frame_number": (3,), "episode_frame_number": (3,)}
    flags = {"terminated": each, "truncated": each, "game_over": (3,), "game_ended": (3,)}
    doubles, parts = {"score": each, "frames": (3,), "seconds": (3,)}, {"pixels": (3, 4 * 84 * 84), "ram": (3, 128)}
    final = {}
    if mode == "SameStep":
        integers |= {"final_lives": each, "final_frame_number": (3,), "final_episode_frame_number": (3,)}
        flags |= {"ended": (3,), "final_game_ended": (3,)}
        doubles |= {"final_score": each, "final_frames": (3,), "final_seconds": (3,)}
        final = {f"final_{name}": shape for name, shape in parts.items()}
    kinds = [("int32", integers), ("bool", flags), ("float64", doubles), ("uint8", parts | final)]
    arrays = {name: (dtype, shape) for dtype, shapes in kinds for name, shape in shapes.items()}
    found = {name: (str(array.dtype), array.shape) for name, array in batch.arrays.items()}
    assert found == {name: array for name, array in arrays.items() if name not in parts}
    port = _emulator.XlaPort(envs._engine, True, True)
    assert {name: array for name, *array in port.results()} == {
        name: list(array) for name, array in arrays.items() if name not in doubles
    }


def test_arrays_of_a_batch_outlive_it() -> None:
    envs = atari.AtariVectorEnv("pong", 2)
    reward = Results(envs._engine, envs._options).batch.arrays["reward"]
    gc.collect()
    reward[:] = 7
    assert reward.tolist() == [7, 7]
