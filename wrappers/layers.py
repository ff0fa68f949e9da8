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

from atari.env.episode_env import EpisodeEnv, can_play
from atari.wrappers._ale_seeding import AleSeeding
from atari.wrappers._checks import Environment
from atari.wrappers._game_statistics import GameStatistics
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
from atari.wrappers.step_limit import StepLimit

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
    outside = [*_of_unit(_lives(task), task.lives_unit, "skip"), *_of_unit(_fire(task), task.fire_unit, "skip")]
    if task.seeding == "ale":
        yield AleSeeding, {}
    yield from _of_unit(_lives(task), task.lives_unit, "frame")
    fire = _of_unit(_fire(task), task.fire_unit, "frame")
    yield from fire + _noops(task) if task.fire == "before_noops" else _noops(task) + fire
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
    yield from _reports(task)


def _of_unit(layers: list[Layer], unit: str, wanted: str) -> list[Layer]:
    return layers if unit == wanted else []


def _lives(task: Any) -> list[Layer]:
    if not task.episodic_life:
        return []
    return [(EpisodicLife, {"on_reset": task.on_reset, "last_life": task.last_life})]


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


def _reports(task: Any) -> Iterator[Layer]:
    """The layers that change no frame: the reports of each step, and the limit of steps."""
    if task.life_loss_info:
        yield LifeLossInfo, {"last_life": task.last_life}
    if task.max_episode_steps is not None:
        yield StepLimit, {"max_episode_steps": task.max_episode_steps}
    yield GameStatistics, {}
    if task.reward is not None:
        yield ExpressionReward, {"reward": task.reward}
    if task.reward_clipping:
        yield ClipReward, {}
