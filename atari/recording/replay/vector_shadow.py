"""The shadow of one environment of a vector: a recorded single environment that repeats its resets and steps.

A vector plays its environments in C++ and does not return the frames inside a step or the no-ops of a reset. A shadow
has the same seed and plays the same actions, so its RAM and frame numbers must be equal after each step.
"""

from collections.abc import Callable
from typing import Any

import gymnasium

from atari._gymnasium import AutoresetMode
from atari.cores.options import SEED_LIMIT
from atari.env import AtariEnv
from atari.making import make_env
from atari.vector.env import AtariVectorEnv
from atari.vector.lanes import Lane

FIRE, NOOP = 1, 0


def make_shadow(
    vector: AtariVectorEnv, index: int, record: Callable[[gymnasium.Env[Any, Any]], Any]
) -> "AleShadow | PresetShadow":
    """The shadow of environment `index`; `record` puts a single environment in a recorder.

    Raises:
        ValueError: games with different actions have wrappers.
    """
    options, lane = vector.options, vector.lanes[index]
    task = options.tasks[index]
    if task.seeding == "ale":
        emulator = task.of_emulator().replace(
            frameskip=task.frameskip, actions="full" if options.mixed else task.actions, max_num_frames_per_episode=None
        )
        return AleShadow(vector, lane, record(AtariEnv(emulator, rom=options.rom)))
    if options.mixed:
        raise ValueError("environments with wrappers can be recorded only if all games have the same actions")
    return PresetShadow(vector, lane, record(make_env(task, rom=options.rom)))


class AleShadow:
    """Repeats an environment with ale-py's options. The frame numbers determine the number of no-ops.

    Args:
        vector, lane: the vector, and the repeated environment in it.
        env: the recorder around the single environment.
    """

    def __init__(self, vector: AtariVectorEnv, lane: Lane, env: Any) -> None:
        self.env, self.lane = env, lane
        self._core: Any = env.get_wrapper_attr("core")
        self._actions = vector.options.actions[lane.index]
        task = vector.options.tasks[lane.index]
        self._fires = task.fire != "never" and FIRE in task.begin_actions
        self._episode_frames = 0

    def reset(self, seed: int | None) -> None:
        """Begin the game that the environment has begun; None continues the core's random numbers."""
        core = self._core
        if seed is not None:
            core.seed(seed % SEED_LIMIT)
        core.reset()
        if self._fires:
            core.act(FIRE)
        while core.frame_number < self.lane.frame_number:
            core.act(NOOP)
            if core.game_over:
                core.reset()
        self.env.recorder.flush_if_full()
        self._episode_frames = self.lane.episode_frame_number

    def step(self, index: int, strength: float, final: int | None) -> None:
        """Repeat a step: an action's index and strength, and in SAME_STEP the frame number at the episode's end."""
        lane, core = self.lane, self._core
        target = lane.frame_number if final is None else int(final)
        went_on = self._episode_frames + target - core.frame_number
        if final is None and lane.episode_frame_number != went_on:
            return self.reset(None)
        if core.frame_number < target:
            self.env.recorder.begin_step()
            while core.frame_number < target and not core.game_over:
                core.act(int(self._actions[index]), strength)
            self.env.recorder.end_step()
        if final is not None:
            self.reset(None)
        self._episode_frames = lane.episode_frame_number


class PresetShadow:
    """Repeats an environment with a preset, by the preset's wrappers. `AleShadow` documents the arguments."""

    def __init__(self, vector: AtariVectorEnv, lane: Lane, env: Any) -> None:
        self.env, self.lane = env, lane
        self._autoreset = vector.options.autoreset_mode
        self._over = False

    def reset(self, seed: int | None) -> None:
        """Begin an episode."""
        self.env.reset(seed=seed)
        self._over = False

    def step(self, index: int, strength: float, final: int | None) -> None:
        """Repeat a step, as `AleShadow.step`; the wrappers find the episode's end themselves."""
        if self._over and self._autoreset == AutoresetMode.DISABLED:
            return
        if self._over:
            return self.reset(None)
        _, _, terminated, truncated, _ = self.env.step(index)
        self._over = terminated or truncated
        if self._over and self._autoreset == AutoresetMode.SAME_STEP:
            self.reset(None)
