import numpy as np
import pytest

from atari.wrappers import StickyActions


@pytest.mark.parametrize("probability", [0.25, 0.5])
def test_repeats_with_this_probability_drawn_each_step(scripted, probability):
    env = StickyActions(scripted(meanings=["NOOP"] * 2000), probability)
    env.reset(seed=4)
    chosen = list(range(2000))
    for action in chosen:
        env.step(action)
    draws = np.random.Generator(np.random.PCG64(4)).random(2000)
    expected, previous = [], 0
    for action, draw in zip(chosen, draws, strict=True):
        previous = action if draw >= probability else previous
        expected.append(previous)
    assert env.unwrapped.actions == expected
    repeated = sum(action != step for step, action in enumerate(expected))
    assert repeated / 2000 == pytest.approx(probability, abs=0.03)


def test_extremes(scripted):
    never, always = StickyActions(scripted(), 0.0), StickyActions(scripted(), 1.0)
    for env in (never, always):
        env.reset(seed=0)
        for action in (3, 2, 1):
            env.step(action)
    assert never.unwrapped.actions == [3, 2, 1]
    assert always.unwrapped.actions == [0, 0, 0]


def test_an_episode_starts_with_noop_as_the_previous_action(scripted):
    env = StickyActions(scripted(), 0.0)
    env.reset(seed=0)
    env.step(3)
    env._probability = 1.0
    env.step(2)
    env.reset()
    env.step(2)
    assert env.unwrapped.actions == [3, 3, 0]


def test_refuses_to_be_sticky_twice(game_env):
    with pytest.raises(ValueError, match=r"of pong are sticky already \(probability 0.25\).*probability=0.0"):
        StickyActions(game_env("pong", repeat_action_probability=0.25))


def test_refuses_games_without_noop(game_env):
    with pytest.raises(ValueError, match=r"NOOP, which is no action of this game.*full_action_space=True"):
        StickyActions(game_env("backgammon"))
    StickyActions(game_env("backgammon", full_action_space=True))


@pytest.mark.parametrize(("value", "error"), [(-0.1, ValueError), (1.5, ValueError), ("x", TypeError)])
def test_refuses(scripted, value, error):
    with pytest.raises(error, match="repeat_action_probability must be"):
        StickyActions(scripted(), value)
