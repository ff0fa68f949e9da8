"""Every ID makes a vector environment through `gymnasium.make_vec`."""

from pathlib import Path

import ale_py
import gymnasium
import numpy as np
import pytest

import atari
from atari._gymnasium import AutoresetMode

pytestmark = pytest.mark.skipif(
    gymnasium.__version__ < "1", reason="Gymnasium 0.29's make_vec passes the options of an ID to no vector entry point"
)


def test_make_vec_is_that_of_ale_py() -> None:
    ours = gymnasium.make_vec("ALE/Pong-v5", num_envs=2, num_threads=1)
    assert isinstance(ours.unwrapped, atari.AtariVectorEnv)
    theirs = ale_py.AtariVectorEnv("pong", 2, repeat_action_probability=0.25)
    for envs in (ours, theirs):
        envs.reset(seed=1)
    for action in (2, 3, 4, 2):
        mine, other = (envs.step(np.full(2, action)) for envs in (ours, theirs))
        assert np.array_equal(mine[0], other[0])


def test_every_id_arrives_here() -> None:
    for env_id in atari.registration.ids():
        assert gymnasium.registry[env_id].vector_entry_point == "atari.vector:AtariVectorEnv"
    ram = gymnasium.make_vec("Breakout-ramNoFrameskip-v4", num_envs=2)
    observation, info = ram.reset(seed=0)
    assert observation.shape == (2, 128)
    before = info["frame_number"]
    assert np.all(ram.step(np.zeros(2, int))[4]["frame_number"] - before == 1)
    skipping = gymnasium.make_vec("Breakout-v0", num_envs=2)
    assert skipping.reset(seed=0)[0].shape == (2, 4, 84, 84)


def test_a_game_of_ones_own(tmp_path: Path) -> None:
    catch = Path(__file__).parents[2] / "examples" / "catch"
    (tmp_path / "vector_catch.toml").write_text((catch / "catch.toml").read_text())
    for env_id in atari.register_game(tmp_path / "vector_catch.toml", catch / "catch.bin"):
        envs = gymnasium.make_vec(env_id, num_envs=2)
        observation, info = envs.reset(seed=0)
        assert observation.shape[1:] == ((128,) if "-ram" in env_id else (4, 84, 84))
        assert info["lives"].tolist() == [3, 3]
        del gymnasium.registry[env_id]


def test_metadata_is_its_own() -> None:
    envs = atari.AtariVectorEnv("pong", 1, autoreset_mode="SameStep")
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert gymnasium.vector.VectorEnv.metadata.get("autoreset_mode") is not AutoresetMode.SAME_STEP
