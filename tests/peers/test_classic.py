"""MuJoCo and Robotics through the old interface, under Gym's IDs, and without a display."""

import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import atari.classic as gym

pytestmark = pytest.mark.peers

NEWEST = {
    "Ant-v2": "Ant-v5",
    "HalfCheetah-v2": "HalfCheetah-v5",
    "Hopper-v3": "Hopper-v5",
    "Humanoid-v1": "Humanoid-v5",
    "Walker2d-v2": "Walker2d-v5",
    "InvertedPendulum-v2": "InvertedPendulum-v5",
    "Pusher-v2": "Pusher-v5",
    "FetchReach-v1": "FetchReach-v4",
    "FetchPickAndPlace-v1": "FetchPickAndPlace-v4",
    "HandReach-v0": "HandReach-v3",
    "HandManipulateEgg-v0": "HandManipulateEgg-v1",
}


@pytest.mark.parametrize("old", NEWEST)
def test_an_old_id_is_the_newest_environment(old: str) -> None:
    env = gym.make(old)
    assert env.spec.id == NEWEST[old]
    env.seed(0)
    first = env.reset()
    assert env.observation_space.contains(first)
    env.action_space.seed(0)
    observation, reward, done, info = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    assert (type(done), type(info)) == (bool, dict)
    assert np.isfinite(reward)
    env.seed(0)
    assert_same(env.reset(), first)
    env.close()


def test_an_episode_is_cut_off_at_the_limit() -> None:
    env = gym.make("Reacher-v2")
    env.reset()
    ends = [env.step(env.action_space.sample())[2:] for _ in range(50)]
    assert [done for done, _ in ends] == [False] * 49 + [True]
    assert ends[-1][1]["TimeLimit.truncated"] is True


def test_robotics_have_goals() -> None:
    env = gym.make("FetchReach-v1")
    assert isinstance(env.unwrapped, gym.GoalEnv)
    observation = env.reset()
    goal, achieved = observation["desired_goal"], observation["achieved_goal"]
    assert (
        env.compute_reward(goal, goal, {}) == 0
    )  # hindsight: the reward if the achieved goal had been the desired one
    assert env.compute_reward(achieved, achieved + 1, {}) == -1
    assert set(env.step(env.action_space.sample())[0]) == {"observation", "achieved_goal", "desired_goal"}


def test_they_are_listed_and_dead_registrations_are_not() -> None:
    listed = set(gym.envs.registry.env_specs)
    assert set(NEWEST.values()) <= listed
    assert not listed & set(NEWEST)


@pytest.mark.parametrize("env_id", ["Walker2d-v2", "FetchPickAndPlace-v1"])
def test_rgb_array_without_a_display(env_id: str) -> None:
    program = (
        f"import atari.classic as gym\nenv = gym.make({env_id!r})\nenv.reset()\nenv.render()\n"
        "print(env.render(mode='rgb_array').std() > 10, env.render(mode='rgb_array').shape)"
    )
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
    environment = {key: value for key, value in os.environ.items() if key not in hidden}
    result = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env={**environment, "MUJOCO_GL": "egl"},
        timeout=120,
    )
    assert result.stdout == "True (480, 480, 3)\n", result.stderr
    assert "there is no display, so env.render() shows nothing" in result.stderr


def assert_same(first: Any, second: Any) -> None:
    if isinstance(first, dict):
        assert first.keys() == second.keys()
        for name in first:
            np.testing.assert_array_equal(first[name], second[name])
    else:
        np.testing.assert_array_equal(first, second)
