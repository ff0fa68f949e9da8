"""Every wrapper and every preset goes through one contract: spaces, seeds, pickling, specs, Gymnasium's checker."""

from functools import partial

import gymnasium
import pytest

from atari import wrappers


def make(wrap, **options):
    return wrap(gymnasium.make("BreakoutNoFrameskip-v4", disable_env_checker=True, **options))


SINGLE = {
    "NoopReset": wrappers.NoopReset,
    "FireReset": wrappers.FireReset,
    "EpisodicLife": wrappers.EpisodicLife,
    "FrameSkip": wrappers.FrameSkip,
    "StickyActions": wrappers.StickyActions,
    "ClipReward": wrappers.ClipReward,
    "FrameStack": wrappers.FrameStack,
    "Grayscale": wrappers.Grayscale,
    "Resize": wrappers.Resize,
    "RamObservation": wrappers.RamObservation,
    "DqnPreprocessing": wrappers.DqnPreprocessing,
    "DqnPreprocessing in colour": partial(wrappers.DqnPreprocessing, grayscale=False, stack_size=None),
    "RamObservation outside": lambda env: wrappers.RamObservation(wrappers.DqnPreprocessing(env)),
}


@pytest.mark.parametrize("name", SINGLE)
def test_wrapper(contract, name):
    contract(partial(make, wrap=SINGLE[name]))


@pytest.mark.parametrize("name", wrappers.PRESETS)
def test_preset(contract, name):
    options = wrappers.preset_options(name)
    contract(partial(make, wrap=lambda env: wrappers.preset(env, name), **options))
