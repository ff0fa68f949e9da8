"""Every wrapper and every preset keeps the contract of environments, `atari.testing.check_env`."""

import warnings
from functools import partial

import gymnasium
import pytest
from tasks import ALE, task

import atari
from atari import wrappers
from atari.testing import check_env
from atari.wrappers.layers import wrap


def make(wrap, **options):
    return wrap(gymnasium.make("BreakoutNoFrameskip-v4", disable_env_checker=True, **options))


SINGLE = {
    "NoopReset": wrappers.NoopReset,
    "FireReset": wrappers.FireReset,
    "EpisodicLife": wrappers.EpisodicLife,
    "FrameSkip": wrappers.FrameSkip,
    "ActionDelay": partial(wrappers.ActionDelay, delay=(2, 5)),
    "ObservationDelay": partial(wrappers.ObservationDelay, delay=(2, 5)),
    "StickyActions": wrappers.StickyActions,
    "ClipReward": wrappers.ClipReward,
    "ExpressionReward": partial(wrappers.ExpressionReward, reward="reward - 5 * lives_lost"),
    "FrameStack": wrappers.FrameStack,
    "LifeLossInfo": wrappers.LifeLossInfo,
    "NoopReset after FIRE": lambda env: wrappers.NoopReset(wrappers.FireReset(env), fire_again=False),
    "Grayscale": wrappers.Grayscale,
    "Resize": wrappers.Resize,
    "RamObservation": wrappers.RamObservation,
    "DqnPreprocessing": wrappers.DqnPreprocessing,
    "DqnPreprocessing in colour": partial(wrappers.DqnPreprocessing, grayscale=False, stack_size=None),
    "DqnPreprocessing of random skips": partial(wrappers.DqnPreprocessing, frame_skip=(1, 5), max_frames=70),
    "DqnPreprocessing of the screen": partial(wrappers.DqnPreprocessing, screen_size=None, max_pool=False),
    "DqnPreprocessing of RAM": partial(wrappers.DqnPreprocessing, obs_type="ram"),
    "RamObservation outside": lambda env: wrappers.RamObservation(wrappers.DqnPreprocessing(env)),
}


TASKS = {
    "ALE": task(**ALE, frameskip=(2, 5), obs_type="rgb", max_episode_steps=17),
    "FIRE outside": task(noops=(0, 6), fire="after_noops", fire_unit="skip", episodic_life=True, on_reset="continue"),
    "lives outside": task(fire="before_noops", noops=(1, 3), episodic_life=True, lives_unit="skip", obs_type="dict"),
    "both outside": task(
        fire="after_noops", third_action=True, fire_unit="skip", episodic_life=True, lives_unit="skip", on_reset="noop"
    ),
    "a reward of its own": task(episodic_life=True, on_reset="continue", reward="reward + lives - 2 * before.lives"),
    "RAM": task(obs_type="ram", stack_num=None, life_loss_info=True, max_episode_steps=30, reward_clipping=True),
}


def contract(make):
    """Check an environment; a warning of Gymnasium's is a fault of ours, and so is another type of a number."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make)
    env = make()
    assert str(gymnasium.make(type(env.spec).from_json(env.spec.to_json()))) == str(env)
    env.reset(seed=4)
    for _ in range(40):
        _, *signals, _ = env.step(env.action_space.sample())
        assert [type(each) for each in signals] == [float, bool, bool]
        if any(signals[1:]):
            env.reset()
    env.close()


@pytest.mark.parametrize("name", TASKS)
def test_task(name):
    """The wrappers one in the other, and the one object that plays them."""
    for nested in (False, True):
        contract(partial(make, wrap=lambda env, nested=nested: wrap(env, TASKS[name], nested=nested)))


@pytest.mark.parametrize("name", SINGLE)
def test_wrapper(name):
    contract(partial(make, wrap=SINGLE[name]))


@pytest.mark.parametrize("name", atari.PRESETS)
def test_preset(name):
    options = wrappers.preset_options(name)
    contract(partial(make, wrap=lambda env: wrappers.preset(env, name), **options))
