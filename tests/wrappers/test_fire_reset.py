import numpy as np
import pytest

import atari
from atari.wrappers import FireReset

MEANINGS = ["NOOP", "FIRE", "UP", "DOWN"]


@pytest.mark.parametrize(
    ("meanings", "arguments", "options", "actions"),
    [
        (MEANINGS, {}, None, [1]),
        (["NOOP", "UP", "FIRE"], {}, None, [2]),
        (["NOOP", "UP"], {"then_action_2": True}, None, []),
        (MEANINGS, {"then_action_2": True}, {"fire": True}, [1, 2]),
        (MEANINGS, {"then_action_2": True}, {"fire": False}, []),
    ],
)
def test_the_actions_of_a_reset(scripted, meanings, arguments, options, actions):
    env = FireReset(scripted(meanings=meanings), **arguments)
    observation, info = env.reset(seed=3, options=options)
    assert env.unwrapped.actions == actions
    assert env.unwrapped.resets == [(3, None)]
    assert info["frame"] == observation.max() == len(actions)


@pytest.mark.parametrize("threshold", [0.0, 0.5, 0.999, 1.0])
def test_fire_is_pressed_at_every_threshold_of_continuous_actions(threshold):
    """No continuous action presses FIRE at a threshold of 1; a reset does, as in ale-py's vector environment."""
    options = {"continuous": True, "continuous_action_threshold": threshold, "repeat_action_probability": 0.0}
    envs = [atari.make("breakout", obs_type="ram", fire=fire, **options) for fire in ("after_noops", "never")]
    for env in envs:
        env.reset(seed=0)
    first, second = (env.step(np.zeros(3, np.float32))[0] for env in envs)
    assert (first != second).any()
    vector = atari.AtariVectorEnv(envs[0].unwrapped.whole_task, 1, num_threads=1)
    vector.reset(seed=0)
    assert (vector.step(np.zeros((1, 3), np.float32))[0] == first).all()


def test_resets_again_if_fire_ends_the_episode_and_shows_the_new_one(scripted):
    env = FireReset(scripted(ends=2), then_action_2=True)
    observation, info = env.reset()
    assert len(env.unwrapped.resets) == 2
    assert info["frame"] == 0
    assert observation.max() == 0


def test_starts_breakout(game_env):
    env = FireReset(game_env("breakout"))
    env.reset(seed=0)
    for _ in range(10):
        env.step(0)
    with_fire = env.unwrapped.core.ram()
    still = game_env("breakout")
    still.reset(seed=0)
    for _ in range(11):
        still.step(0)
    ball_y = 101
    assert still.core.ram()[ball_y] == 0, "no ball before FIRE"
    assert with_fire[ball_y] != 0


def test_presses_the_button_of_a_stick(game_env):
    env = FireReset(game_env("breakout", continuous=True))
    discrete = FireReset(game_env("breakout"))
    env.reset(seed=0)
    discrete.reset(seed=0)
    np.testing.assert_array_equal(env.unwrapped.core.ram(), discrete.unwrapped.core.ram())
