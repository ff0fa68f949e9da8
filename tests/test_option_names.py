"""An option has its name in every place, and a wrong name is refused with the nearest right one."""

import inspect
from collections.abc import Callable
from functools import partial
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


DOORS: dict[str, tuple[str, Callable[..., Any]]] = {
    "make": ("atari.make", partial(atari.make, "pong")),
    "preset": ("atari.make", partial(atari.make, "pong", preset="dqn2015")),
    "single": ("AtariEnv", partial(atari.AtariEnv, "pong")),
    "vector": ("AtariVectorEnv", partial(atari.AtariVectorEnv, "pong", 2)),
}
"""By door, its name in errors and how it is called."""


@pytest.mark.parametrize(
    ("door", "given", "nearest"),
    [
        ("preset", "clip_rewards", "clip_reward"),
        ("preset", "num_stack", "stack_num"),
        ("preset", "img_hieght", "img_height"),
        ("preset", "terminal_on_life_loss", "episodic_life"),
        ("make", "frame_skip", "frameskip"),
        ("make", "frame_stack", "stack_num"),
        ("make", "stack_num", "stack_num"),
        ("make", "n_envs", "num_envs"),
        ("make", "grayscale", "obs_type"),
        ("single", "frame_skip", "frameskip"),
        ("single", "screen_size", "img_height"),
        ("single", "sticky_actions", "repeat_action_probability"),
        ("vector", "stack_size", "stack_num"),
        ("vector", "num_stack", "stack_num"),
        ("vector", "reward_clip", "clip_reward"),
    ],
)
def test_an_unknown_option_is_named_with_the_nearest_one(door: str, given: str, nearest: str) -> None:
    name, make = DOORS[door]
    with pytest.raises(TypeError) as error:
        make(**{given: 3})
    assert str(error.value).startswith(f"{name} has no option {given!r}")
    assert repr(nearest) in str(error.value)


def test_an_option_unlike_all_others_lists_what_is_accepted() -> None:
    with pytest.raises(TypeError, match="AtariEnv has no option 'zzz'; it has game, mode, difficulty"):
        atari.AtariEnv("pong", zzz=3)  # type: ignore[call-arg]


def test_an_option_of_presets_without_one() -> None:
    with pytest.raises(TypeError, match="'clip_reward' is an option of presets; give one"):
        atari.make("pong", clip_reward=False)


@pytest.mark.parametrize("door", ["preset", "vector"])
def test_two_names_of_one_option(door: str) -> None:
    with pytest.raises(
        TypeError, match="clip_reward and reward_clipping are two names of one option; give one of them"
    ):
        DOORS[door][1](clip_reward=True, reward_clipping=True)


def test_the_options_of_preprocessing_are_those_of_the_vector_environment() -> None:
    assert PREPROCESSING_OPTIONS
    assert set(PREPROCESSING_OPTIONS) <= set(inspect.signature(atari.AtariVectorEnv).parameters)
    assert not set(PREPROCESSING_OPTIONS) & set(inspect.signature(atari.AtariEnv).parameters)
