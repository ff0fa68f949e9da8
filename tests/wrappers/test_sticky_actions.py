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
