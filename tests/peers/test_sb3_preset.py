"""Preset `baselines` beside Stable-Baselines3's `AtariWrapper` and `VecFrameStack`, on ale-py's environment."""

import ale_py
import numpy as np
import pytest

from atari import AtariEnv
from atari.wrappers import StickyActions, preset

pytestmark = pytest.mark.peers

CASES = {
    "defaults": {},
    "sticky in the emulator": {"probability": 0.25},
    "sticky in a wrapper": {"sticky_wrapper": 0.25},
    "truncation inside a skip": {"limit": 203},
    "whole games": {"episodic_life": False, "clip_reward": False},
}


@pytest.mark.parametrize("game", ["breakout", "pong", "ms_pacman", "bank_heist", "frogger", "qbert", "carnival"])
@pytest.mark.parametrize("case", CASES)
def test_same_bytes(game, case):
    compare(game, **CASES[case])


def compare(game, probability=0.0, sticky_wrapper=0.0, limit=None, episodic_life=True, clip_reward=True, steps=600):
    from stable_baselines3.common.atari_wrappers import AtariWrapper
    from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack

    options = {"frameskip": 1, "repeat_action_probability": probability, "max_num_frames_per_episode": limit}
    wrap = {
        "terminal_on_life_loss": episodic_life,
        "clip_reward": clip_reward,
        "action_repeat_probability": sticky_wrapper,
    }
    theirs = VecFrameStack(DummyVecEnv([lambda: AtariWrapper(ale_py.AtariEnv(game, **options), **wrap)]), 4)
    env = AtariEnv(game, **options)
    ours = StickyActions(env, sticky_wrapper) if sticky_wrapper else env
    ours = preset(ours, "baselines", episodic_life=episodic_life, clip_reward=clip_reward)

    theirs.seed(3)
    expected = theirs.reset()
    observation, _ = ours.reset(seed=3)
    rng = np.random.default_rng(3)
    truncations = 0
    for _ in range(steps):
        np.testing.assert_array_equal(observation, channels_first(expected[0]))
        action = int(rng.integers(env.action_space.n))
        expected, rewards, ended, infos = theirs.step(np.array([action]))
        observation, reward, terminated, truncated, _ = ours.step(action)
        assert (reward, terminated or truncated) == (rewards[0], ended[0])
        assert infos[0]["TimeLimit.truncated"] == (truncated and not terminated)
        if ended[0]:
            truncations += truncated
            np.testing.assert_array_equal(observation, channels_first(infos[0]["terminal_observation"]))
            observation, _ = ours.reset()
    assert (truncations > 0) == (limit is not None)


def channels_first(stack):
    """Stable-Baselines3 stacks (84, 84, 4), this package (4, 84, 84)."""
    return stack.transpose(2, 0, 1)
