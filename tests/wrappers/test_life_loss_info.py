import ale_py
import numpy as np
import pytest

from atari.wrappers import DqnPreprocessing, FireReset, LifeLossInfo


def play(env, steps, action=2):
    """The flags and lives of each step."""
    rows = []
    for _ in range(steps):
        *_, terminated, truncated, info = env.step(action)
        rows.append((terminated, truncated, info["lives"]))
    return rows


def test_a_loss_is_reported_once_and_the_game_goes_on(game_env):
    env = LifeLossInfo(DqnPreprocessing(FireReset(game_env("breakout"))))
    twin = DqnPreprocessing(FireReset(game_env("breakout")))
    env.reset(seed=0)
    twin.reset(seed=0)
    before, lost = 5, []
    for step in range(300):
        action = 1 if step % 9 == 0 else 2
        observation, reward, terminated, truncated, info = env.step(action)
        expected = twin.step(action)
        np.testing.assert_array_equal(observation, expected[0])
        assert (reward, truncated, info) == (expected[1], expected[3], expected[4])
        over = expected[2]
        assert terminated == (over or 0 < info["lives"] < before)
        lost += [info["lives"]] if terminated else []
        before = info["lives"]
        if over:
            break
    assert lost == [4, 3, 2, 1, 0]


def test_is_ale_pys(game_env):
    theirs = ale_py.AtariVectorEnv("breakout", 1, life_loss_info=True, noop_max=1, reward_clipping=False)
    ours = LifeLossInfo(DqnPreprocessing(FireReset(game_env("breakout")), end_frames="gymnasium", padding_type="zero"))
    theirs.reset(seed=0)
    ours.reset(seed=0)
    losses = 0
    for step in range(200):
        action = 1 if step % 9 == 0 else 3
        expected, reward, terminated, truncated, info = theirs.step(np.array([action]))
        observation, own_reward, *flags, own = ours.step(action)
        assert (own_reward, *flags, own["lives"]) == (reward[0], terminated[0], truncated[0], info["lives"][0])
        np.testing.assert_array_equal(observation, expected[0])
        losses += flags[0]
        if own["lives"] == 0:
            break
    assert losses == 5


@pytest.mark.parametrize(("last_life", "reported"), [(False, [False, False]), (True, [True, False])])
def test_the_last_life(game_env, last_life, reported):
    """Frogger continues for a while after it."""
    env = LifeLossInfo(game_env("frogger"), last_life=last_life)
    env.reset(seed=0)
    lives = 4
    while lives > 0:
        *_, terminated, _, info = env.step(1)
        if info["lives"] == lives - 1 > 0:
            assert terminated
        lives = info["lives"]
    assert not env.unwrapped.core.game_over
    assert [terminated, env.step(1)[2]] == reported


def test_a_loss_in_the_step_of_a_limit_is_both(game_env):
    def made(limit):
        env = LifeLossInfo(DqnPreprocessing(game_env("breakout"), max_frames=limit))
        env.reset(seed=0)
        env.step(1)
        return env

    rows = play(made(1000), 60)
    lost = rows.index((True, False, 4))
    assert play(made(4 * (lost + 2)), lost + 1)[-1] == (True, True, 4)
