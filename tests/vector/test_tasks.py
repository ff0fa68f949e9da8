"""A task is nested wrappers, one object around a single environment, and the lane of a vector: the same bytes.

The nested wrappers share no code with the engine but the emulator and its `ObservationStack`, so each is the test of the
other. The one object that `atari.make` returns plays the engine's `Episode` on the core of a single environment.
`composed` replaces that class by NumPy and OpenCV. `Lanes` compares all results.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from field_values import CASES, DRAWN
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st
from lane_oracle import Lanes, random_action
from task_strategies import tasks
from tasks import nested
from vector_tools import as_bytes

import atari
from atari import wrappers
from atari.env import AtariEnv
from atari.registry.making import make_env
from atari.task import Task
from atari.wrappers.layers import layers_of

GAMES = ("breakout", "ms_pacman", "bank_heist", "frogger", "pong", "backgammon", "video_checkers", "space_invaders")
MODES = ("NextStep", "SameStep", "Disabled")


def play(task: Task, mode: str, seed: int, steps: int, singles: Sequence[Any] | None = None) -> int:
    """Random steps, with resets in between, and a snapshot to which all return; the number of ended episodes.

    Without `singles`, a lane plays beside nested wrappers, and another beside the environment of `make_env`.
    """
    singles = [nested(task), make_env(task)] if singles is None else singles
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
    play(task, mode, seed, 45)


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
        for envs in (atari.AtariVectorEnv(task, 1, num_threads=1), atari.make(task)):
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
    env: Any = AtariEnv(task.emulator_task().replace(obs_type="rgb" if task.pool_rgb else task.obs_type))
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
    play(task, mode, seed, 45, [composed(task)])


STEPS = {"frogger": 1000}
"""By game, how many steps a trace has; Frogger goes on for a while after the last life."""


def trace(task: Task, vector: bool) -> Iterator[Any]:
    """All that an agent gets in some steps of actions that depend on the task's action space alone."""
    env: Any = atari.AtariVectorEnv(task, 1, num_threads=1, autoreset_mode="NextStep") if vector else atari.make(task)
    space = env.single_action_space if vector else env.action_space
    generator = np.random.default_rng(3)
    observation, info = env.reset(seed=5)
    yield str(space), as_bytes(observation), int(np.max(info["frame_number"]))
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
        yield as_bytes(observation), *numbers
    env.close()


def acts(field: str, vector: bool, **fields: Any) -> bool:
    """Whether a field changes what an agent gets in a task with these other fields."""
    case = CASES[field]
    others = {"game": "breakout", **case.needs, **case.seen, **fields}
    one, other = Task(**others), Task(**{**others, field: case.value})
    assert field in one.differences(other)
    return any(mine != theirs for mine, theirs in zip(trace(one, vector), trace(other, vector), strict=True))


@pytest.mark.parametrize("vector", [False, True])
@pytest.mark.parametrize("field", ["game", *DRAWN])
def test_every_field_acts(field: str, vector: bool) -> None:
    assert acts(field, vector)


@pytest.mark.parametrize("vector", [False, True])
@pytest.mark.parametrize("field", ["stack_num", "padding", "seamless_lives"])
def test_fields_of_images_act_on_ram(field: str, vector: bool) -> None:
    assert acts(field, vector, obs_type="ram")
