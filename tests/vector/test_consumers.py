"""Gymnasium's vector wrappers around `AtariVectorEnv`, and loops in the manner of CleanRL."""

from typing import Any

import gymnasium
import numpy as np
import pytest

import atari

wrappers = pytest.importorskip("gymnasium.wrappers.vector", reason="added in Gymnasium 1.0")


def make(**options: object) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("breakout", 3, num_threads=2, **options)  # type: ignore[arg-type]


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


def test_spaces_sample_what_is_taken() -> None:
    envs = make()
    envs.action_space.seed(0)
    envs.reset(seed=0)
    for _ in range(10):
        envs.step(envs.action_space.sample())


def test_returns_are_those_of_single_environments() -> None:
    """Statistics are recorded inside the clipping, as in CleanRL's loops, and for whole games.

    A preset gives `episode` itself, which Gymnasium's wrapper refuses to write again, hence the other key.
    """
    options: dict[str, Any] = {"preset": "gymnasium", "repeat_action_probability": 0.0}
    envs = atari.AtariVectorEnv("breakout", 2, reward_clipping=False, **options)
    recorded = wrappers.TransformReward(wrappers.RecordEpisodeStatistics(envs, stats_key="seen"), np.sign)
    rng = np.random.default_rng(0)
    actions = rng.integers(4, size=(700, 2))
    recorded.reset(seed=6)
    games: list[list[tuple[float, int]]] = [[], []]
    over = np.zeros((700, 2), bool)
    for step in range(700):
        _, reward, terminated, truncated, info = recorded.step(actions[step])
        assert set(reward.tolist()) <= {0, 1}
        over[step] = terminated | truncated
        for index in np.flatnonzero(over[step]):
            games[index].append((info["seen"]["r"][index], info["seen"]["l"][index]))
            assert info["episode"]["r"][index] == info["seen"]["r"][index]
    for index in range(2):
        env = gymnasium.wrappers.RecordEpisodeStatistics(
            atari.make("breakout", preset="gymnasium", repeat_action_probability=0.0), stats_key="seen"
        )
        env.reset(seed=6 + index)
        alone: list[tuple[float, int]] = []
        for step in range(700):
            if step and over[step - 1, index]:
                env.reset()  # the reset takes a step of the vector
                continue
            *_, alone_info = env.step(int(actions[step, index]))
            if over[step, index]:
                alone.append((alone_info["seen"]["r"], alone_info["seen"]["l"]))
        assert alone == games[index]
        assert len(alone) >= 2
