"""Preset `envpool` beside EnvPool's Atari environments."""

import numpy as np
import pytest

from atari import AtariEnv
from atari.task.env_ids import stem
from atari.wrappers import preset, preset_options
from atari.wrappers.layers import wrap

pytestmark = pytest.mark.peers

CASES = {
    "defaults": {},
    "episodic life, clipped, sticky": {"episodic_life": True, "clip_reward": True, "probability": 0.25},
    "truncation": {"episodic_life": True, "limit": 57},
}


# EnvPool's screens have 210 lines, so games with more lines are left out.
@pytest.mark.parametrize("game", ["breakout", "pong", "ms_pacman", "bank_heist", "frogger", "qbert", "seaquest"])
@pytest.mark.parametrize("case", CASES)
def test_same_bytes(game, case):
    compare(game, **CASES[case])


def compare(game, probability=0.0, limit=27_000, episodic_life=False, clip_reward=False, seed=5, steps=600):
    import envpool

    theirs = envpool.make(
        f"{stem(game)}-v5",
        env_type="gymnasium",
        num_envs=1,
        seed=seed,
        max_episode_steps=limit,
        repeat_action_probability=probability,
        episodic_life=episodic_life,
        reward_clip=clip_reward,
    )
    env = AtariEnv(game, **{**preset_options("envpool"), "repeat_action_probability": probability})
    ours = preset(env, "envpool", episodic_life=episodic_life, clip_reward=clip_reward)
    ours = wrap(ours.unwrapped, ours.unwrapped.task.replace(max_frames=4 * limit))
    draws = Draws(seed)
    fire = "FIRE" in env.get_action_meanings()

    def reset():
        return ours.reset(options={"noops": 1 + draws.below(30) - fire})

    env.core.seed(seed)
    expected, info = theirs.reset()
    observation, own_info = reset()
    rng = np.random.default_rng(seed)
    ended = False
    truncations = 0
    for _ in range(steps):
        np.testing.assert_array_equal(observation, expected[0])
        np.testing.assert_array_equal(env.core.ram(), info["ram"][0])
        assert own_info["lives"] == info["lives"][0]
        action = int(rng.integers(env.action_space.n))
        expected, *signals, info = theirs.step(np.array([action]))
        if ended:  # EnvPool's step was the reset
            observation, own_info = reset()
            own_signals = [0.0, False, False]
        else:
            observation, *own_signals, own_info = ours.step(action)
        assert own_signals == [signal[0] for signal in signals]
        ended = own_signals[1] or own_signals[2]
        truncations += own_signals[2]
    assert (truncations > 0) == (limit < steps)


class Draws:
    """The numbers EnvPool draws for its no-ops: a Mersenne Twister, and C++'s uniform integers."""

    def __init__(self, seed):
        self._words = np.random.MT19937()
        self._words._legacy_seeding(seed)

    def below(self, count):
        product = int(self._words.random_raw()) * count
        while product % 2**32 < 2**32 % count:
            product = int(self._words.random_raw()) * count
        return product >> 32
