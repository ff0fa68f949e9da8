"""A task is one environment with wrappers, and the lane of a vector: the same bytes for every field.

The wrappers share no code with the engine but the emulator and its `ObservationStack`, so each is the test of the other.
`composed` replaces that class by NumPy and OpenCV.
"""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import TimeLimit
from hypothesis import HealthCheck, assume, example, given, settings
from hypothesis import strategies as st
from task_strategies import VALUES, tasks

from atari import wrappers
from atari.env import AtariEnv
from atari.task import Task
from atari.task.task import FIELDS
from atari.wrappers.layers import layers_of

GAMES = ("breakout", "ms_pacman", "bank_heist", "frogger", "pong", "backgammon", "video_checkers", "space_invaders")
NUMBERS = ("lives", "frame_number", "episode_frame_number")
MODES = ("NextStep", "SameStep", "Disabled")


class Lane:
    """A vector of one environment, beside a single environment of the same task."""

    def __init__(self, task: Task, mode: str, single: Any = None) -> None:
        self.task, self.mode = task, mode
        self.envs = task.make_vec(1, num_threads=1, autoreset_mode=mode)
        self.single: Any = task.make() if single is None else single
        self.done = False
        self.ends = 0
        assert self.single.action_space == self.envs.single_action_space
        assert self.single.observation_space == self.envs.single_observation_space

    def reset(self, seed: int | None, **options: Any) -> None:
        """Reset both, and compare."""
        observation, info = self.envs.reset(seed=seed, options=options)
        alone = {name: value for name, value in options.items() if name != "reset_mask"}
        expected, expected_info = self.single.reset(seed=seed, options=alone)
        self.same(observation, expected)
        self.same_info(info, expected_info, "reset")
        self.done = False

    def step(self, action: Any) -> None:
        """A step of both; the single environment is reset where the vector resets by itself."""
        if self.done and self.mode == "Disabled":
            return self.reset(None, reset_mask=np.ones(1, bool))
        observation, reward, terminated, truncated, info = self.envs.step(np.asarray(action)[None])
        if self.done:  # NEXT_STEP
            expected, expected_info = self.single.reset()
            self.same(observation, expected)
            self.same_info(info, expected_info, "reset")
            assert (terminated[0], truncated[0], reward[0]) == (False, False, 0)
            self.done = False
            return None
        expected, score, over, cut, expected_info = self.single.step(action)
        assert reward[0] == score
        reported = self.task.life_loss_info and over and not self.single.unwrapped.core.game_over
        # ale-py reports a limit that is reached with a lost life as the lost life alone; a single environment reports
        # both, and so does a vector at `max_episode_steps`, which ale-py does not have.
        assert (terminated[0], truncated[0]) == (over, cut and (not reported or self.has_no_more_steps()))
        self.done = cut or (over and not reported)
        self.ends += self.done
        if self.mode == "SameStep" and (self.done or reported):
            assert info["_final_obs"][0] == self.done
        if self.mode == "SameStep" and self.done:
            self.same(info["final_obs"], expected)
            self.same_info(info["final_info"], expected_info, "end")
            expected, expected_info = self.single.reset()
            self.done = False
        self.same(observation, expected)
        self.same_info(info, expected_info, "step")

    def has_no_more_steps(self) -> bool:
        """Whether the single environment has reached `max_episode_steps`."""
        env = self.single
        while not isinstance(env, TimeLimit):
            if env is env.unwrapped:
                return False
            env = env.env
        return env._elapsed_steps >= env._max_episode_steps

    def same(self, observation: Any, expected: Any) -> None:
        """Whether observations are equal to the byte."""
        if isinstance(expected, dict):
            assert observation.keys() == expected.keys()
            for name in expected:
                self.same(observation[name], expected[name])
            return
        assert observation[0].dtype == expected.dtype
        assert np.array_equal(observation[0], expected)

    def same_info(self, info: Any, expected: Any, where: str) -> None:
        """Whether the numbers of `info` are equal."""
        assert {name: info[name][0] for name in NUMBERS} == {name: expected[name] for name in NUMBERS}, where

    def close(self) -> None:
        """Close both."""
        self.envs.close()
        self.single.close()


def play(lane: Lane, seed: int, steps: int) -> None:
    """Random steps, with resets in between, and a snapshot to which both return."""
    generator = np.random.default_rng(seed)
    lane.reset(seed)
    taken: Any = None
    for step in range(steps):
        lane.step(_action(lane.single.action_space, generator))
        if step == steps // 3 and not lane.done:
            taken = lane.envs.snapshot(), lane.single.snapshot()
        if step == steps // 2 and taken is not None:
            lane.envs.restore(None, taken[0])
            lane.single.restore(taken[1])
            lane.done = False
        if step == 3 * steps // 4 and lane.mode != "SameStep":
            lane.reset(seed + 1 if seed % 2 else None)


def _action(space: gymnasium.Space[Any], generator: np.random.Generator) -> Any:
    if isinstance(space, gymnasium.spaces.Discrete):
        return int(generator.integers(space.n))
    assert isinstance(space, gymnasium.spaces.Box)
    return generator.uniform(space.low, space.high).astype(np.float32)


@given(tasks(GAMES), st.sampled_from(MODES), st.integers(0, 2**32 - 2))
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
def test_wrappers_are_the_lane_of_a_vector(task: Task, mode: str, seed: int) -> None:
    lane = Lane(task, mode)
    try:
        play(lane, seed, 60)
    finally:
        lane.close()


@pytest.mark.parametrize("mode", MODES)
def test_lives_that_are_reported(mode: str) -> None:
    task = Task.of("breakout", life_loss_info=True, repeat_action_probability=0.0, max_num_frames_per_episode=600)
    lane = Lane(task, mode)
    try:
        play(lane, 0, 400)
        assert lane.ends > 1
    finally:
        lane.close()


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
    assume(task.end_frames == "last")
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
    lane = Lane(task, mode, composed(task))
    try:
        play(lane, seed, 60)
    finally:
        lane.close()


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
        action = _action(space, generator)
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
    assert {*VALUES, "game", "interventions", *NOT_SINGLE} >= set(FIELDS)
