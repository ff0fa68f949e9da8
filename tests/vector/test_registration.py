"""Every ID makes a vector environment through `gymnasium.make_vec`: the one that ale-py's ID makes."""

from pathlib import Path
from typing import Any

import ale_py
import gymnasium
import numpy as np
import pytest

import atari
from atari.base.gymnasium_versions import AutoresetMode
from atari.task import env_ids

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


def test_only_ids_of_ale_v5_are_preprocessed() -> None:
    """As in ale-py; any other ID is one environment, single and in a vector."""
    assert {spec.vector_entry_point for spec in map(gymnasium.spec, env_ids.ids())} == {
        "atari.registry.making:make_AtariVectorEnv"
    }
    preprocessed = [env_id for env_id in env_ids.ids() if env_ids.is_ale_py_vector(env_id)]
    assert preprocessed == [f"ALE/{env_ids.stem(game.id)}-v5" for game in atari.games.playable()]
    assert gymnasium.make_vec("ALE/Pong-v5", 1).unwrapped.task.preprocessed  # type: ignore[attr-defined]
    for env_id in ("ALE/Pong-ram-v5", "Pong-v0", "PongNoFrameskip-v4", "Pong-ram-v4"):
        envs = gymnasium.make_vec(env_id, 1)
        assert envs.unwrapped.task == atari.Task.of(env_id)  # type: ignore[attr-defined]


def test_a_preset_decides_over_the_id() -> None:
    envs: Any = gymnasium.make_vec("ALE/Pong-v5", 2, preset="baselines")
    assert envs.unwrapped.task == atari.Task.of("ALE/Pong-v5", preset="baselines")
    assert envs.unwrapped.task == atari.AtariVectorEnv("pong", 2, preset="baselines").task


def test_wrappers_need_single_environments() -> None:
    with pytest.raises(gymnasium.error.Error, match=r"Cannot use `vector_entry_point` .* with the wrappers argument"):
        gymnasium.make_vec("ALE/Pong-v5", num_envs=2, wrappers=[gymnasium.wrappers.RecordEpisodeStatistics])
    sync = gymnasium.make_vec(
        "ALE/Pong-v5", 2, vectorization_mode="sync", wrappers=[gymnasium.wrappers.RecordEpisodeStatistics]
    )
    assert sync.reset(seed=0)[0].shape == (2, 210, 160, 3)


def test_a_game_of_ones_own(tmp_path: Path) -> None:
    catch = Path(__file__).parents[2] / "examples" / "catch"
    (tmp_path / "vector_catch.toml").write_text((catch / "catch.toml").read_text())
    for env_id in atari.register_game(tmp_path / "vector_catch.toml", catch / "catch.bin"):
        envs = gymnasium.make_vec(env_id, num_envs=2)
        observation, info = envs.reset(seed=0)
        assert observation.shape[1:] == ((128,) if "-ram" in env_id else gymnasium.make(env_id).observation_space.shape)
        assert info["lives"].tolist() == [3, 3]
        del gymnasium.registry[env_id]


def test_metadata_is_its_own() -> None:
    envs = atari.AtariVectorEnv("pong", 1, autoreset_mode="SameStep")
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert gymnasium.vector.VectorEnv.metadata.get("autoreset_mode") is not AutoresetMode.SAME_STEP
