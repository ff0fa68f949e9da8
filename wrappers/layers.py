"""The wrappers that play a task around a single environment, and the order in which they are nested.

S is the frame skip, `DqnPreprocessing`; L is `EpisodicLife`, N `NoopReset`, F `FireReset`. From the inside out:

============= ============== ======================= ==================
`fire_unit`   `lives_unit`   FIRE after no-ops       FIRE before no-ops
============= ============== ======================= ==================
"frame"       "frame"        L N F S                 L F N S
"frame"       "skip"         N F S L                 F N S L
"skip"        "frame"        L N S F
"skip"        "skip"         N S L F
============= ============== ======================= ==================

A layer inside S plays single frames, a layer outside S whole skips. If the episode ends during a layer's reset, the
layer resets the layers inside it once more, and continues.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import gymnasium
from gymnasium import spaces
from gymnasium.wrappers import TimeLimit

from atari.base.gymnasium_versions import adds_episode
from atari.cores.ale_random import AleRandom
from atari.env.episode_env import STEPS_WITHOUT_PROGRESS, EpisodeEnv, WaitingCheck, can_play
from atari.env.restorable import Restorable, RestorableWrapper
from atari.wrappers._checks import Environment, action_meanings, require_atari
from atari.wrappers.action_delay import ActionDelay
from atari.wrappers.clip_reward import ClipReward
from atari.wrappers.dqn_preprocessing import DqnPreprocessing
from atari.wrappers.episodic_life import EpisodicLife
from atari.wrappers.expression_reward import ExpressionReward
from atari.wrappers.fire_reset import FireReset
from atari.wrappers.frame_stack import FrameStack
from atari.wrappers.life_loss_info import LifeLossInfo
from atari.wrappers.noop_reset import NoopReset
from atari.wrappers.observation_delay import ObservationDelay
from atari.wrappers.ram_observation import RamObservation

Layer = tuple[type[gymnasium.Wrapper[Any, Any, Any, Any]], Mapping[str, Any]]


def wrap(env: Environment, task: Any, *, nested: bool = False) -> Environment:
    """Put the preprocessing of a task around an `AtariEnv` made with `frameskip=1` and the task's other options.

    Args:
        env: the `AtariEnv`, possibly wrapped.
        task: the task.
        nested: whether the result is the wrappers of `layers_of`, one in the other, and never an `EpisodeEnv`.
    """
    if not nested and can_play(env, task):
        return EpisodeEnv(env, task)
    for wrapper, arguments in layers_of(task):
        env = wrapper(env, **arguments)
    return env


def layers_of(task: Any) -> Iterator[Layer]:
    """The wrappers of a task and their arguments, from the inside out."""
    lives, fire, noops = _lives(task), _fire(task), _noops(task)
    outside = lives * (task.lives_unit == "skip") + fire * (task.fire_unit == "skip")
    if task.seeding == "ale":
        yield AleSeeding, {}
    yield from lives * (task.lives_unit == "frame")
    inside = fire * (task.fire_unit == "frame")
    yield from inside + noops if task.fire == "before_noops" else noops + inside
    yield DqnPreprocessing, _preprocessing(task, stacks=not outside)
    yield from outside
    if outside and task.stack_num is not None:
        yield FrameStack, {"stack_size": task.stack_num, "padding_type": task.padding}
    if task.kind.is_dict:
        yield RamObservation, {}
    if task.action_delay:
        yield ActionDelay, {"delay": task.action_delay}
    if task.observation_delay:
        yield ObservationDelay, {"delay": task.observation_delay}
    if task.life_loss_info:
        yield LifeLossInfo, {"last_life": task.last_life}
    if task.max_episode_steps is not None:
        yield StepLimit, {"max_episode_steps": task.max_episode_steps}
    yield GameStatistics, {}
    if task.reward is not None:
        yield ExpressionReward, {"reward": task.reward}
    if task.reward_clipping:
        yield ClipReward, {}


def _lives(task: Any) -> list[Layer]:
    arguments = {"on_reset": task.on_reset, "last_life": task.last_life}
    return [(EpisodicLife, arguments)] if task.episodic_life else []


def _fire(task: Any) -> list[Layer]:
    return [] if task.fire == "never" else [(FireReset, {"then_action_2": task.third_action})]


def _noops(task: Any) -> list[Layer]:
    low, high = task.noops
    if high == 0 and task.seeding != "ale":  # ale's seeding draws even a number that must be 0
        return []
    arguments = {"noop_max": high, "noop_min": low, "fire_counts": task.fire_counts}
    if task.fire == "before_noops":
        arguments["fire_again"] = task.fire_again
    return [(NoopReset, arguments)]


def _preprocessing(task: Any, *, stacks: bool) -> dict[str, Any]:
    skip = {"frame_skip": task.frameskip, "seamless_lives": task.seamless_lives, "max_frames": task.max_frames}
    skip["stack_size"] = task.stack_num if stacks else None
    if stacks:
        skip["padding_type"] = task.padding
    if not task.kind.image:
        return {**skip, "obs_type": "ram"}
    return {
        **skip,
        "screen_size": (task.img_width, task.img_height),
        "grayscale": task.kind.is_gray,
        "max_pool": task.maxpool,
        "pool_rgb": task.pool_rgb,
        "end_frames": task.end_frames,
    }


class AleSeeding(RestorableWrapper):
    """`reset(seed=...)` seeds the emulator, and the numbers of no-ops and frames, with the seed itself.

    So does ale-py's vector environment, whose random draws these are. The `AtariEnv` keeps the generator, for its
    snapshots and copies; this wrapper sets it, also when `gymnasium.make(env.spec)` makes the environment again. Seeds
    are below 2**31.

    Args:
        env: an `AtariEnv`, possibly wrapped.
    """

    def __init__(self, env: Environment) -> None:
        super().__init__(env)
        require_atari(env, "AleSeeding").driver.ale_random = AleRandom()


class StepLimit(Restorable, TimeLimit):
    """Truncate episodes after `max_episode_steps` steps of the agent.

    The spec of a `TimeLimit` is the environment's spec with another `max_episode_steps`, which `gymnasium.make` applies
    inside all other wrappers. The steps would then be frames. `gymnasium.make(env.spec)` puts this one in its place.

    Args:
        env: the environment.
        max_episode_steps: the most steps of an episode, which begins with each reset.
    """

    _state = ("_elapsed_steps",)

    spec = gymnasium.Wrapper.spec


class GameStatistics(RestorableWrapper):
    """Add the counts of `AtariEnv` to `info`: rewards before clipping, and whole games, across lost lives.

    Each `info` has, under EnvPool's names: "reward", the reward before clipping, a float; "elapsed_step", the steps of
    the game despite lost lives; "terminated", whether the game is over. When a game has ended, in the step or inside
    the reset, `info` has "episode", see `atari.wrappers.preset`. Gymnasium's `RecordEpisodeStatistics` adds this key
    itself: inside it, the info of a step has none.

    In games with FIRE, the first 9,000 frames in which nothing happens give a warning: the game may wait for it.

    Args:
        env: an `AtariEnv` with wrappers that do not change the reward.
    """

    def __init__(self, env: Environment) -> None:
        super().__init__(env)
        self._atari = require_atari(env, "GameStatistics")
        meanings = action_meanings(env) if isinstance(env.action_space, spaces.Discrete) else []
        self._waiting = WaitingCheck(self._atari, meanings)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset, and add the statistics to `info`."""
        observation, info = self.env.reset(seed=seed, options=options)
        return observation, self._with_statistics(info, 0.0, truncated=False)

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Step, and add the statistics to `info`."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        game = self._atari.driver.played
        game.steps += 1
        if game.steps % STEPS_WITHOUT_PROGRESS == 0:
            self._waiting.warn(action)
        return observation, reward, terminated, truncated, self._with_statistics(info, reward, truncated)

    def _with_statistics(self, info: dict[str, Any], reward: Any, truncated: bool) -> dict[str, Any]:
        driver = self._atari.driver
        over, ended = driver.core.game_over, driver.ended
        info = {**info, "reward": reward, "elapsed_step": driver.played.steps, "terminated": over}
        if ended is not None or truncated:  # `truncated` may come from a wrapper, unseen by the environment
            if not adds_episode(self):
                info["episode"] = ended or driver.played.statistics(driver.core)
            driver.ended = None
        return info
