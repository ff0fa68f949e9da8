"""TimeLimit, AtariPreprocessing and FrameStack with the old interface."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1

import atari
import atari.classic as gym
from atari.classic.wrappers import AtariPreprocessing, FrameStack, TimeLimit
from atari.wrappers import FrameStack as ModernFrameStack


class Endless(gym.Env):
    """Counts steps; done at `end`."""

    action_space = gym.spaces.Discrete(2)
    observation_space = gym.spaces.Box(0, 100, (2,))

    def __init__(self, end: int = 100) -> None:
        self.end = end

    def reset(self) -> Any:
        self.n = 0
        return np.array([0, 0], np.float32)

    def step(self, action: Any) -> Any:
        self.n += 1
        return np.array([self.n, action], np.float32), 1.0, self.n >= self.end, {}


# TimeLimit


def test_a_time_limit_truncates_an_episode() -> None:
    env = TimeLimit(Endless(), 3)
    for _ in range(2):
        env.reset()
        steps = [env.step(0)[2:] for _ in range(4)]
        assert steps[:2] == [(False, {}), (False, {})]
        assert steps[2:] == [(True, {"TimeLimit.truncated": True})] * 2  # a step after the end repeats it


def test_an_end_at_the_limit_is_an_end() -> None:
    env = TimeLimit(Endless(end=3), 3)
    env.reset()
    assert [env.step(0)[2:] for _ in range(3)][-1] == (True, {"TimeLimit.truncated": False})


def test_scripts_change_the_limit() -> None:
    env: Any = gym.make("CartPole-v0")
    env._max_episode_steps = 2
    env.reset()
    assert [env.step(0)[2] for _ in range(2)] == [False, True]
    assert env._elapsed_steps == 2


def test_the_limit_may_come_from_the_spec() -> None:
    inner = gym.make("MountainCar-v0").env  # type: ignore[attr-defined]
    assert TimeLimit(inner)._max_episode_steps == 200
    for wrong in (None, 0):
        with pytest.raises(ValueError, match="max_episode_steps is a number of steps, 1 or more, got"):
            TimeLimit(Endless(), wrong)


def test_a_games_limit_is_of_steps() -> None:
    env = gym.make("Pong-ram-v0")
    env.reset()
    env._elapsed_steps = 9_990  # type: ignore[attr-defined]
    ends = [env.step(0)[2:] for _ in range(10)]
    assert [done for done, _ in ends] == [False] * 9 + [True]
    assert ends[-1][1]["TimeLimit.truncated"] is True


# AtariPreprocessing


def test_preprocessing_is_gymnasiums() -> None:
    ours = AtariPreprocessing(gym.make("PongNoFrameskip-v4"), noop_max=10, terminal_on_life_loss=True)
    theirs = gymnasium.wrappers.AtariPreprocessing(
        atari.make("PongNoFrameskip-v4"), noop_max=10, terminal_on_life_loss=True
    )
    assert repr(ours.observation_space) == "Box(84, 84)"
    ours.seed(2)
    np.testing.assert_array_equal(ours.reset(), theirs.reset(seed=2)[0])
    rng = np.random.default_rng(0)
    for _ in range(60):
        action = int(rng.integers(6))
        observation, reward, done, info = ours.step(action)
        expected = theirs.step(action)
        np.testing.assert_array_equal(observation, expected[0])
        assert (reward, done) == (expected[1], expected[2] or expected[3])
        assert info["episode_frame_number"] == expected[4]["episode_frame_number"]


def test_the_limit_counts_the_inner_frames() -> None:
    env = AtariPreprocessing(TimeLimit(gym.make("PongNoFrameskip-v4"), 22), noop_max=0)
    env.reset()
    steps = [env.step(0)[2:] for _ in range(6)]
    assert [done for done, _ in steps] == [False] * 5 + [True]  # 22 frames are five steps of four, and a half
    assert steps[-1][1]["TimeLimit.truncated"] is True


@needs_gymnasium_1
def test_preprocessing_is_for_games_without_a_frame_skip() -> None:
    with pytest.raises(TypeError, match=r"AtariPreprocessing is for Atari games, such as 'PongNoFrameskip-v4', got <"):
        AtariPreprocessing(gym.make("CartPole-v0"))
    with pytest.raises(ValueError, match="frame-skip"):
        AtariPreprocessing(gym.make("Pong-v4"))


# FrameStack


def test_a_stack_is_the_last_observations() -> None:
    env = FrameStack(Endless(), 3)
    assert repr(env.observation_space) == "Box(3, 2)"
    np.testing.assert_array_equal(env.reset(), np.zeros((3, 2)))
    env.step(0)
    stack, reward, done, info = env.step(1)
    assert (stack.shape, len(stack), reward, done, info) == ((3, 2), 3, 1.0, False, {})
    np.testing.assert_array_equal(np.array(stack), [[0, 0], [1, 0], [2, 1]])
    np.testing.assert_array_equal(stack[-1], [2, 1])


def test_preprocessed_stacks_are_those_of_the_new_interface() -> None:
    ours = FrameStack(AtariPreprocessing(gym.make("BreakoutNoFrameskip-v4"), noop_max=0), 4)
    theirs = ModernFrameStack(
        gymnasium.wrappers.AtariPreprocessing(atari.make("BreakoutNoFrameskip-v4"), noop_max=0), 4
    )
    assert ours.observation_space.shape == (4, 84, 84)
    ours.seed(0)
    np.testing.assert_array_equal(ours.reset(), theirs.reset(seed=0)[0])
    for action in (1, 2, 2, 3):
        np.testing.assert_array_equal(ours.step(action)[0], theirs.step(action)[0])
    assert ours.unwrapped.ale.lives() == 5  # type: ignore[attr-defined]
    assert ours.render(mode="rgb_array").shape == (210, 160, 3)
    assert str(ours) == "<FrameStack<AtariPreprocessing<TimeLimit<AtariEnv<BreakoutNoFrameskip-v4>>>>>"
