"""An option has its name in every place, and a wrong name is refused with the nearest right one."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import atari
from atari import wrappers
from atari.task.resolution import ALIASES, OPTIONS


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
    "task": ("Task.of", partial(atari.Task.of, "pong")),
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
        ("make", "n_envs", "num_envs"),
        ("make", "grayscale", "obs_type"),
        ("make", "noop_max", "noops"),
        ("make", "use_fire_reset", "fire"),
        ("make", "render", "render_mode"),
        ("make", "presett", "preset"),
        ("task", "sticky_actions", "repeat_action_probability"),
        ("task", "clip_rewards", "clip_reward"),
        ("task", "presett", "preset"),
        ("single", "frame_skip", "frameskip"),
        ("single", "screen_size", "img_height"),
        ("single", "sticky_actions", "repeat_action_probability"),
        ("single", "clip_rewards", "clip_reward"),
        ("vector", "stack_size", "stack_num"),
        ("vector", "num_stack", "stack_num"),
        ("vector", "reward_clip", "clip_reward"),
        ("vector", "num_thread", "num_threads"),
        ("vector", "noops_max", "noop_max"),
    ],
)
def test_an_unknown_option_is_named_with_the_nearest_one(door: str, given: str, nearest: str) -> None:
    name, make = DOORS[door]
    with pytest.raises(TypeError) as error:
        make(**{given: 3})
    assert str(error.value).startswith(f"{name} has no option {given!r}")
    assert repr(nearest) in str(error.value)


OWN = {
    "task": ["preset"],
    "make": ["preset", "render_mode", "core", "rom", "disable_env_checker"],
    "single": ["render_mode", "core", "rom"],
    "vector": "num_envs preset batch_size num_threads noop_max use_fire_reset grayscale dtype rom".split(),
}
"""By door, options that it has beside those of a task."""


@pytest.mark.parametrize("door", OWN)
def test_an_option_unlike_all_others_lists_what_is_accepted(door: str) -> None:
    name, make = DOORS[door]
    with pytest.raises(TypeError, match=f"{name} has no option 'zzz'; it has ") as error:
        make(zzz=3)
    listed = str(error.value).partition("it has ")[2].split(", ")
    assert {*OPTIONS, *ALIASES, *OWN[door]} <= {*listed}
    assert len(listed) == len(set(listed))


@pytest.mark.parametrize("door", ["task", "make", "single"])
def test_an_option_of_vectors_alone(door: str) -> None:
    name, make = DOORS[door]
    with pytest.raises(TypeError) as error:
        make(num_envs=3)
    assert str(error.value) == (
        f"{name} has no option 'num_envs'; AtariVectorEnv, which plays many environments, has 'num_envs'"
    )


def test_an_option_of_wrappers_without_a_preset() -> None:
    env = atari.make("breakout", episodic_life=True, stack_num=2, clip_reward=True)
    task = env.unwrapped.task  # type: ignore[attr-defined]
    assert (task.episodic_life, task.stack_num, task.reward_clipping) == (True, 2, True)
    assert env.reset(seed=0)[0].shape == (2, 210, 160, 3)
    with pytest.raises(ValueError, match=r"AtariEnv plays without wrappers, .* use atari\.make"):
        atari.AtariEnv("breakout", episodic_life=True)


@pytest.mark.parametrize("door", ["task", "make", "preset", "single", "vector"])
def test_two_names_of_one_option(door: str) -> None:
    with pytest.raises(
        TypeError, match="clip_reward and reward_clipping are two names of one option; give one of them"
    ):
        DOORS[door][1](clip_reward=True, reward_clipping=True)
