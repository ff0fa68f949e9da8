"""An option has its name in every place, and a wrong name is refused with the nearest right one."""

import inspect
from typing import Any

import numpy as np
import pytest

import atari
from atari import wrappers
from atari.validation import PREPROCESSING_OPTIONS


@pytest.mark.parametrize("name", ["clip_reward", "reward_clipping"])
def test_both_names_of_clipping(name: str) -> None:
    options: dict[str, Any] = {"preset": "baselines", "episodic_life": False, name: False}
    single, envs = atari.make("space_invaders", **options), atari.AtariVectorEnv("space_invaders", 1, **options)
    raw = atari.make("space_invaders", preset=None, **wrappers.preset_options("baselines"))
    around = wrappers.preset(raw, "baselines", episodic_life=False, **{name: False})  # type: ignore[arg-type]
    for env in (single, around, envs):
        env.reset(seed=0)
    highest = 0.0
    for action in [1, 2, 1, 3] * 60:
        reward = single.step(action)[1]
        assert reward == around.step(action)[1] == envs.step(np.full(1, action))[1][0]
        highest = max(highest, float(reward))
    assert highest >= 5


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: atari.make("pong", preset="dqn2015", clip_rewards=False), "atari.make .* did you mean 'clip_reward'"),
        (lambda: atari.make("pong", frame_skip=3), "atari.make has no option 'frame_skip'; did you mean 'frameskip'"),
        (lambda: atari.make("pong", clip_reward=False), "'clip_reward' is an option of presets; give one"),
        (lambda: atari.AtariEnv("pong", frame_skip=3), "AtariEnv has no option 'frame_skip'; did you mean 'frameskip'"),
        (lambda: atari.AtariEnv("pong", zzz=3), "AtariEnv has no option 'zzz'; it has game, mode, difficulty"),
        (
            lambda: atari.make("pong", preset="dqn2015", num_stack=3),
            "atari.make has no option 'num_stack'; AtariVectorEnv has 'stack_num', and a single .* by atari.wrappers",
        ),
        (lambda: atari.make("pong", frame_stack=3), "AtariVectorEnv has 'stack_num'"),
        (lambda: atari.make("pong", stack_num=3), "AtariVectorEnv has 'stack_num'"),
        (lambda: atari.make("pong", preset="dqn2015", img_hieght=3), "AtariVectorEnv has 'img_height'"),
        (lambda: atari.make("pong", n_envs=3), "AtariVectorEnv has 'num_envs'"),
        (lambda: atari.make("pong", grayscale=True), "did you mean 'obs_type'"),
        (lambda: atari.make("pong", preset="dqn2015", terminal_on_life_loss=True), "did you mean 'episodic_life'"),
        (lambda: atari.AtariEnv("pong", screen_size=84), "AtariEnv has no .* AtariVectorEnv has 'img_height'"),
        (lambda: atari.AtariEnv("pong", sticky_actions=0.5), "did you mean 'repeat_action_probability'"),
        (lambda: atari.AtariVectorEnv("pong", 2, stack_size=3), "AtariVectorEnv .* did you mean 'stack_num'"),
        (lambda: atari.AtariVectorEnv("pong", 2, num_stack=3), "AtariVectorEnv .* did you mean 'stack_num'"),
        (lambda: atari.AtariVectorEnv("pong", 2, reward_clip=True), "did you mean 'clip_reward'"),
        (
            lambda: atari.AtariVectorEnv("pong", 2, clip_reward=True, reward_clipping=False),
            "clip_reward and reward_clipping are two names of one option; give one of them",
        ),
        (
            lambda: atari.make("pong", preset="dqn2015", clip_reward=True, reward_clipping=True),
            "two names of one option",
        ),
    ],
)
def test_wrong_names(make: Any, text: str) -> None:
    with pytest.raises(TypeError, match=text):
        make()


def test_the_options_of_preprocessing_are_those_of_the_vector_environment() -> None:
    assert PREPROCESSING_OPTIONS
    assert set(PREPROCESSING_OPTIONS) <= set(inspect.signature(atari.AtariVectorEnv).parameters)
    assert not set(PREPROCESSING_OPTIONS) & set(inspect.signature(atari.AtariEnv).parameters)
