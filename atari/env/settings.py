"""The settings of the C++ classes, filled by name from a task, and the `_emulator.Episode` of a task."""

import enum
from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np
from gymnasium import spaces

import atari._emulator as _emulator
from atari.cores.compiled import reward_formula
from atari.cores.native import as_ale_reads
from atari.games.actions import Action
from atari.task import Task
from atari.task.observation_kinds import Kind

_Settings = TypeVar("_Settings")


def filled(settings: _Settings, **fields: Any) -> _Settings:
    """A settings object with these fields set."""
    for name, value in fields.items():
        setattr(settings, name, value)
    return settings


def filled_by_name(settings: _Settings, task: Task, **others: Any) -> _Settings:
    """A settings object, with each field that is not in `others` set to the task's field of its name.

    Names select the members of enumerations. A number stands for the range of it alone.

    Raises:
        AttributeError: a task lacks a field.
    """
    fields = [name for name, member in vars(type(settings)).items() if isinstance(member, property)]
    values: dict[str, Any] = {name: getattr(task, name) for name in fields if name not in others}
    if "frameskip" in values:
        values["frameskip"] = task.frames
    if "repeat_action_probability" in values:
        values["repeat_action_probability"] = as_ale_reads(values["repeat_action_probability"])
    for name, value in values.items():
        kind = type(getattr(settings, name))
        if issubclass(kind, enum.Enum):
            values[name] = kind[value.upper()]
        elif kind is tuple and isinstance(value, int):
            values[name] = value, value
    return filled(settings, **values, **others)


def observation_settings(task: Task) -> _emulator.ObservationSettings:
    """The settings with which the engine pools, resizes and stacks frames, or stacks RAM."""
    height, width = image_shape(task)
    size = {"img_height": height, "img_width": width, "stack_num": task.stack_num or 1}
    stacked = task.kind.image is not None or task.stack_num is not None
    pixels = pixel_format(task.kind, pool_rgb=task.pool_rgb) if stacked else _emulator.PixelFormat.NONE
    return filled_by_name(_emulator.ObservationSettings(), task, pixels=pixels, **size)


def episode_settings(task: Task, **changed: Any) -> _emulator.EpisodeSettings:
    """The settings with which episodes begin, are played and end; `changed` has fields in place of the task's."""
    alone = task.players == 1 and not task.preprocessed
    return filled_by_name(_emulator.EpisodeSettings(), task, **{"acts_after_end": alone, **changed})


def make_episode(
    task: Task,
    settings: _emulator.EpisodeSettings | None = None,
    *,
    observed: bool = True,
    begin_actions: Iterable[Action] | None = None,
    idle: Iterable[int] = (0,),
    **options: Any,
) -> _emulator.Episode:
    """The rules, counters and stack of a task, which plays on the core of each call.

    Args:
        task: the task.
        settings: the settings in place of the task's.
        observed: whether there are observations and a reward of the task's own; without, only games are played.
        begin_actions: the actions that can begin an episode; None means the task's.
        idle: the action of each player who is out, an ALE number.
        **options: other arguments of `_emulator.Episode`: `stacked`, `draw`, `seed`.

    Raises:
        ValueError: the task has an image size that a vector does not support.
    """
    game = task.definition
    blind = filled(_emulator.ObservationSettings(), pixels=_emulator.PixelFormat.NONE)
    seen = observation_settings(task) if observed else blind
    return _emulator.Episode(
        # The core has the sticky actions.
        episode_settings(task, repeat_action_probability=0.0) if settings is None else settings,
        seen,
        rows=game.screen.shape[0],
        format=game.screen.format,
        ram=observed and (task.kind.is_dict or seen.pixels == blind.pixels),
        begin_actions=list(map(int, task.begin_actions if begin_actions is None else begin_actions)),
        idle=list(idle),
        reward=reward_formula(game, task.reward) if observed and task.reward is not None else None,
        **options,
    )


def image_shape(task: Task) -> tuple[int, int]:
    """(rows, columns) of an image."""
    rows, columns = task.definition.screen.shape
    return task.img_height or rows, task.img_width or columns


def pixel_format(kind: Kind, *, pool_rgb: bool = False) -> _emulator.PixelFormat:
    """The format of a stack of observations."""
    return _emulator.PixelFormat["GRAY_OF_RGB" if pool_rgb and kind.is_gray else kind.pixels.upper()]


def observation_space(task: Task, *, engines: bool = False) -> spaces.Space[Any]:
    """The space of one observation. With `engines`, images always have an axis for the stack."""
    kind = task.kind
    stack = (task.stack_num or 1,) if task.stack_num or (engines and kind.image) else ()
    if not kind.image:
        return spaces.Box(0, 255, (*stack, 128), np.uint8)
    image = spaces.Box(0, 255, (*stack, *image_shape(task), *kind.colours), np.uint8)
    return spaces.Dict({"image": image, "ram": spaces.Box(0, 255, (128,), np.uint8)}) if kind.ram else image
