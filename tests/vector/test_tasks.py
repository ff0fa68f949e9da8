"""A task is nested wrappers, one object around a single environment, and the lane of a vector: the same bytes.

The nested wrappers share no code with the engine but the emulator and its `ObservationStack`, so each is the test of the
other. The one object that `atari.make` returns plays the engine's `Episode` on the core of a single environment.
`composed` replaces that class by NumPy and OpenCV. `Lanes` compares all results.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from field_values import DRAWN
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st
from lane_oracle import Lanes, random_action
from task_strategies import tasks
from tasks import nested

from atari import wrappers
from atari.env import AtariEnv
from atari.task import Task
from atari.task.fields import FIELDS
from atari.wrappers.layers import layers_of

GAMES = ("breakout", "ms_pacman", "bank_heist", "frogger", "pong", "backgammon", "video_checkers", "space_invaders")
MODES = ("NextStep", "SameStep", "Disabled")


def play(task: Task, mode: str, seed: int, steps: int, singles: Sequence[Any] | None = None) -> int:
    """Random steps, with resets in between, and a snapshot to which all return; the number of ended episodes.

    Without `singles`, a lane plays beside nested wrappers, and another beside the environment that `atari.make` returns.
    """
    singles = [nested(task), task.make()] if singles is None else singles
    lanes = Lanes([task] * len(singles), mode, singles)
    generator = np.random.default_rng(seed)
    try:
        lanes.reset(seed)
        for step in range(steps):
            if lanes.done and mode == "Disabled":
                lanes.reset(None, [lane.done for lane in lanes.lanes])
            else:
                lanes.step(lanes.sample(generator))
            if step == steps // 3:
                lanes.save()
            if step == steps // 2:
                lanes.restore(range(len(singles)))
            if step == 3 * steps // 4 and mode != "SameStep":
                lanes.reset(seed + 1 if seed % 2 else None)
    finally:
        lanes.close()
    return lanes.ends


@given(tasks(GAMES), st.sampled_from(MODES), st.integers(0, 2**32 - 2))
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
def test_wrappers_and_one_object_are_the_lanes_of_a_vector(task: Task, mode: str, seed: int) -> None:
    play(task, mode, seed, 60)


@pytest.mark.parametrize("mode", MODES)
def test_lives_that_are_reported(mode: str) -> None:
    task = Task.of("breakout", life_loss_info=True, repeat_action_probability=0.0, max_num_frames_per_episode=600)
    assert play(task, mode, 0, 400) > 1


@pytest.mark.parametrize("actions", [("LEFT", "NOOP"), ("RIGHT",), ("UP", "LEFT")])
def test_episodes_begin_alike_for_agents_with_some_of_the_actions(actions: tuple[str, ...]) -> None:
    """FIRE, action 2 and NOOP are those of the game, also where they are none of the agent's."""
    some, preset = Task.of("breakout", preset="baselines", actions=actions), {"UP": "full"}.get(actions[0], "minimal")
    every = Task.of("breakout", preset="baselines", actions=preset)
    shown = []
    for task in (some, every):
        for envs in (task.make_vec(1, num_threads=1), task.make()):
            observation, info = envs.reset(seed=7)
            shown.append((np.squeeze(observation).tobytes(), int(np.max(info["frame_number"]))))
    assert len({*shown}) == 1


def composed(task: Task) -> Any:
    """The task by wrappers that share no code with `ObservationStack`, in place of `DqnPreprocessing`.

    Raises:
        hypothesis.errors.UnsatisfiedAssumption: they cannot express it.
    """
    arrays = task.obs_type in ("grayscale", "rgb", "ram")
    assume(arrays and isinstance(task.frameskip, int) and task.max_frames is None and not task.seamless_lives)
    assume(task.end_frames == "last" and task.preprocessed)
    # `FrameSkip` pools two frames of a skip that was cut, and a lost life shows the last frame, not the last image.
    assume(not task.maxpool or (task.frameskip <= 2 and (task.on_reset != "continue" or task.lives_unit == "skip")))
    env: Any = AtariEnv(task.of_emulator().replace(obs_type="rgb" if task.pool_rgb else task.obs_type))
    for wrapper, arguments in layers_of(task):
        if wrapper is wrappers.FrameStack:
            continue
        if wrapper is not wrappers.DqnPreprocessing:
            env = wrapper(env, **arguments)
            continue
        env = wrappers.FrameSkip(env, task.frameskip, task.maxpool)
        env = wrappers.Grayscale(env) if task.pool_rgb else env
        rows, columns = task.definition.screen.shape
        if task.obs_type != "ram":
            env = wrappers.Resize(env, (task.img_height or rows, task.img_width or columns))
        if arguments["stack_size"] is not None:
            env = wrappers.FrameStack(env, task.stack_num, task.padding)
    outside = any(wrapper is wrappers.FrameStack for wrapper, _ in layers_of(task))
    return wrappers.FrameStack(env, task.stack_num, task.padding) if outside else env


@given(tasks(GAMES), st.sampled_from(MODES), st.integers(0, 2**32 - 2))
@example(Task("breakout", actions="full", frameskip=4, life_loss_info=True, max_episode_steps=25), "NextStep", 0)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
def test_an_independent_composition_is_the_lane_of_a_vector(task: Task, mode: str, seed: int) -> None:
    fields = {"end_frames": "last", "seamless_lives": False, "max_frames": None}
    if task.obs_type != "ram" and not task.pool_rgb:
        fields["obs_type"] = "grayscale" if seed % 2 else "rgb"
    if not isinstance(task.frameskip, int) or task.maxpool:
        fields["frameskip"] = 1 + seed % 2
    task = task.replace(**fields)
    play(task, mode, seed, 60, [composed(task)])


LIVES = {"episodic_life": True, "frameskip": 4}
ACTING: dict[str, tuple[dict[str, Any], Any]] = {
    "game": ({}, "pong"),
    "mode": ({}, 4),
    "difficulty": ({}, 1),
    "actions": ({}, "full"),
    "continuous": ({}, True),
    "continuous_action_threshold": ({"continuous": True}, 0.9),
    "repeat_action_probability": ({}, 0.0),
    "frameskip": ({}, (2, 5)),
    "interventions": ({}, ["strong_ball"]),
    "noops": ({}, (5, 9)),
    "fire": ({}, "after_noops"),
    "fire_counts": ({"fire": "after_noops", "noops": (4, 4)}, True),
    "third_action": ({"fire": "after_noops"}, True),
    "fire_unit": ({"fire": "after_noops"}, "skip"),
    "fire_again": ({"fire": "before_noops", "noops": (100, 100), "max_num_frames_per_episode": 90}, False),
    "seeding": ({"noops": (0, 30)}, "ale"),
    "episodic_life": ({"fire": "after_noops"}, True),
    "lives_unit": ({**LIVES, "fire": "after_noops"}, "skip"),
    "on_reset": ({**LIVES, "fire": "after_noops"}, "continue"),
    "last_life": ({**LIVES, "game": "frogger", "obs_type": "ram", "on_reset": "continue"}, True),
    "seamless_lives": ({**LIVES, "fire": "after_noops", "on_reset": "continue", "stack_num": 4}, True),
    "life_loss_info": ({"fire": "after_noops"}, True),
    "max_num_frames_per_episode": ({}, 90),
    "max_frames": ({}, 90),
    "max_episode_steps": ({}, 20),
    "obs_type": ({}, "ram"),
    "img_height": ({"img_height": 84, "img_width": 84}, 60),
    "img_width": ({"img_height": 84, "img_width": 84}, 60),
    "stack_num": ({}, 2),
    "maxpool": ({"game": "ms_pacman"}, True),
    "pool_rgb": ({"game": "ms_pacman", "obs_type": "grayscale", "maxpool": True}, True),
    "padding": ({"stack_num": 4}, "reset"),
    "end_frames": ({"max_num_frames_per_episode": 30, "frameskip": 4}, "gymnasium"),
    "reward": ({"fire": "after_noops"}, "reward + player_x"),
    "reward_clipping": ({"game": "seaquest"}, True),
}
"""By field, the others with which it acts, and a value other than the default."""

OF_RAM: dict[str, tuple[dict[str, Any], Any]] = {
    "stack_num of RAM": ({"obs_type": "ram"}, 2),
    "padding of RAM": ({"obs_type": "ram", "stack_num": 4}, "reset"),
    "seamless_lives of RAM": (
        {**LIVES, "fire": "after_noops", "on_reset": "continue", "stack_num": 4, "obs_type": "ram"},
        True,
    ),
}
"""The fields that act on RAM as on images."""

STEPS = {"frogger": 1000}
"""By game, how many steps a trace has; Frogger goes on for a while after the last life."""

NOT_SINGLE = ("players", "sound_obs", "agent_indicator", "zero_sum", "rules", "rom_md5")
"""Fields of several players (tests/multiplayer), of sound (tests/test_env.py), and what identifies the game."""


def trace(task: Task, vector: bool) -> list[Any]:
    """All that an agent gets in some steps of actions that depend on the task's action space alone."""
    env: Any = task.make_vec(1, num_threads=1, autoreset_mode="NextStep") if vector else task.make()
    space = env.single_action_space if vector else env.action_space
    generator = np.random.default_rng(3)
    observation, info = env.reset(seed=5)
    seen: list[Any] = [str(space), _bytes(observation), int(np.max(info["frame_number"]))]
    done = False
    for _ in range(STEPS.get(task.game, 220)):
        action = random_action(space, generator)
        if vector:
            observation, reward, terminated, truncated, info = env.step(np.asarray(action)[None])
        elif done:
            observation, info = env.reset()
            reward, terminated, truncated = 0.0, False, False
        else:
            observation, reward, terminated, truncated, info = env.step(action)
        done = bool(np.max(terminated)) or bool(np.max(truncated))
        numbers = (float(np.max(reward)), done, int(np.max(info["frame_number"])))
        seen.append((_bytes(observation), *numbers))
    env.close()
    return seen


def _bytes(observation: Any) -> bytes:
    parts = observation.values() if isinstance(observation, dict) else [observation]
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


@pytest.mark.parametrize("vector", [False, True])
@pytest.mark.parametrize("case", [*ACTING, *OF_RAM])
def test_every_field_acts(case: str, vector: bool) -> None:
    others, value = {**ACTING, **OF_RAM}[case]
    field = case.removesuffix(" of RAM")
    base = Task(**{"game": "breakout", **others})
    changed = Task(**{"game": "breakout", **others, field: value})
    assert set(base.differences(changed)) >= {field}
    assert trace(base, vector) != trace(changed, vector)


def test_every_field_is_tested() -> None:
    assert {*ACTING, *NOT_SINGLE} == set(FIELDS)
    assert {*DRAWN, "game", *NOT_SINGLE} == set(FIELDS)
