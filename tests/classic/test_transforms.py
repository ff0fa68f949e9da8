"""The small wrappers: each changes one thing and keeps the rest."""

import sys
from typing import Any

import cv2
import gymnasium
import numpy as np
import pytest

import atari.classic as gym
from atari.classic import wrappers


class Echo(gym.Env):
    """Observations are the last action; the reward is its sum."""

    action_space = gym.spaces.Box(np.array([-2.0, 0.0]), np.array([2.0, 4.0]))
    observation_space = gym.spaces.Dict(a=gym.spaces.Discrete(3), b=gym.spaces.Box(-9, 9, (2,)))

    def reset(self) -> Any:
        return {"a": 1, "b": np.zeros(2, np.float32)}

    def step(self, action: Any) -> Any:
        return {"a": 2, "b": np.asarray(action, np.float32)}, float(np.sum(action)), True, {}


def test_clip_action() -> None:
    env = wrappers.ClipAction(Echo())
    env.reset()
    assert env.step([-5, 9])[:2][1] == 2.0
    assert env.step([1, 3])[0]["b"].tolist() == [1, 3]


def test_rescale_action() -> None:
    env = wrappers.RescaleAction(Echo(), -1, 1)
    assert (env.action_space.low.tolist(), env.action_space.high.tolist()) == ([-1, -1], [1, 1])  # type: ignore[attr-defined]
    env.reset()
    assert env.step([-1, 1])[0]["b"].tolist() == [-2, 4]
    assert env.step([0, 0])[0]["b"].tolist() == [0, 2]


def test_flatten_observation() -> None:
    env = wrappers.FlattenObservation(Echo())
    assert repr(env.observation_space) == "Box(5,)"
    assert env.reset().tolist() == [0, 1, 0, 0, 0]
    assert env.step([1, 2])[0].tolist() == [0, 0, 1, 1, 2]
    parts = wrappers.FlattenDictWrapper(Echo(), ["b", "a"])
    assert (parts.observation_space.shape, parts.reset().tolist()) == ((3,), [0, 0, 1])


def test_transform_observation_and_reward() -> None:
    env = wrappers.TransformReward(wrappers.TransformObservation(Echo(), lambda o: o["b"] + 1), np.sign)
    assert env.reset().tolist() == [1, 1]
    observation, reward, done, info = env.step([1, 2])
    assert (observation.tolist(), reward, done, info) == ([2, 3], 1.0, True, {})


def test_gray_and_smaller_images() -> None:
    env = gym.make("Pong-v4")
    gray = wrappers.GrayScaleObservation(env)
    small = wrappers.ResizeObservation(wrappers.GrayScaleObservation(env, keep_dim=True), 84)
    assert (gray.observation_space.shape, small.observation_space.shape) == ((210, 160), (84, 84, 1))
    env.seed(0)
    colours = env.reset()
    env.seed(0)
    image = gray.reset()
    assert (image.shape, image.dtype) == ((210, 160), np.uint8)
    expected = cv2.cvtColor(colours, cv2.COLOR_RGB2GRAY)
    np.testing.assert_array_equal(image, expected)
    env.seed(0)
    np.testing.assert_array_equal(small.reset()[..., 0], cv2.resize(expected, (84, 84), interpolation=cv2.INTER_AREA))


def test_only_gymnasiums_preprocessing_needs_opencv(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    env = gym.make("PongNoFrameskip-v4")
    assert wrappers.ResizeObservation(wrappers.GrayScaleObservation(env), 42).reset().shape == (42, 42)
    with pytest.raises(
        gymnasium.error.DependencyNotInstalled, match=r"needs OpenCV: .* pip install opencv-python-headless$"
    ):
        wrappers.AtariPreprocessing(env)


def test_statistics_of_episodes() -> None:
    env = wrappers.RecordEpisodeStatistics(gym.make("CartPole-v0"))
    env.seed(0)
    for _ in range(2):
        env.reset()
        done, steps = False, 0
        while not done:
            _, _, done, info = env.step(1)
            steps += 1
            assert ("episode" in info) == done
        assert (info["episode"]["r"], info["episode"]["l"]) == (steps, steps)


def test_cleanrls_wrappers() -> None:
    env: gym.Env = gym.make("BreakoutNoFrameskip-v4")
    assert isinstance(env, wrappers.TimeLimit)
    env._max_episode_steps = 5
    env = wrappers.ResizeObservation(wrappers.RecordEpisodeStatistics(env), (84, 84))
    env = wrappers.FrameStack(wrappers.GrayScaleObservation(env), 4)
    assert np.array(env.reset()).shape == (4, 84, 84)
    *_, (_, _, done, info) = [env.step(0) for _ in range(5)]
    assert (done, info["episode"]["l"]) == (True, 5)
