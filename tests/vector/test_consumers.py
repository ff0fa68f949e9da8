"""Gymnasium's vector wrappers around `AtariVectorEnv`, and loops in the manner of CleanRL."""

import numpy as np
import pytest
from vector_tools import make

wrappers = pytest.importorskip("gymnasium.wrappers.vector", reason="added in Gymnasium 1.0")


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_record_episode_statistics(mode: str) -> None:
    envs = wrappers.RecordEpisodeStatistics(make(autoreset_mode=mode, max_num_frames_per_episode=80))
    envs.reset(seed=0)
    rewards = np.zeros(3)
    for step in range(20):
        _, reward, _, truncated, info = envs.step(np.full(3, 1 + step % 3))
        rewards += reward
        assert truncated.all() == (step == 19)
    assert info["episode"]["l"].tolist() == [20, 20, 20]
    assert info["episode"]["r"].tolist() == rewards.tolist()


def test_reward_and_observation_wrappers() -> None:
    envs = wrappers.NormalizeReward(wrappers.RecordEpisodeStatistics(make()))
    envs.reset(seed=0)
    for _ in range(30):
        _, reward, _, _, _ = envs.step(np.array([1, 2, 3]))
    assert np.isfinite(reward).all()
    scaled = wrappers.TransformObservation(make(), lambda observation: observation / 255.0)
    observation, _ = scaled.reset(seed=0)
    assert 0 < observation.max() <= 1


def test_infos_as_a_list() -> None:
    envs = wrappers.DictInfoToList(make())
    _, infos = envs.reset(seed=0)
    assert [info["env_id"] for info in infos] == [0, 1, 2]
    *_, infos = envs.step(np.zeros(3, int))
    assert [info["lives"] for info in infos] == [5, 5, 5]
