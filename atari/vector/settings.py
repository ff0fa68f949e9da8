"""The settings of the vector engine, filled by name from the options."""

import enum
from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any, TypeVar

from atari.cores.native import as_ale_reads
from atari.protocols import Protocol

NO_LIMIT = 2**31 - 1

_Settings = TypeVar("_Settings")


def filled(settings: _Settings, **fields: Any) -> _Settings:
    """A settings object of the engine with these fields set."""
    for name, value in fields.items():
        setattr(settings, name, value)
    return settings


def filled_by_name(settings: _Settings, task: Any, **others: Any) -> _Settings:
    """A settings object of the engine, with each field that is not in `others` set to the task's attribute of its name.

    Names stand for the members of enumerations.

    Raises:
        AttributeError: the task lacks a field.
    """
    fields = [name for name, member in vars(type(settings)).items() if isinstance(member, property)]
    values = {name: _as_engine_reads(name, getattr(task, name)) for name in fields if name not in others}
    for name, value in values.items():
        kind = type(getattr(settings, name))
        if issubclass(kind, enum.Enum):
            values[name] = kind[value.upper()]
    return filled(settings, **values, **others)


def _frames(frameskip: Any) -> tuple[int, int]:
    """From how many frames and below how many a skip is drawn."""
    return frameskip if isinstance(frameskip, tuple) else (frameskip, frameskip + 1)


_READS: Mapping[str, Callable[[Any], Any]] = {"frameskip": _frames, "repeat_action_probability": as_ale_reads}
"""By field, what makes the engine's value of an option where they differ."""


def _as_engine_reads(name: str, value: Any) -> Any:
    return _READS[name](value) if name in _READS else value


def task_of(protocol: Protocol, players: int, *, img_height: int, img_width: int, stack_num: int) -> SimpleNamespace:
    """The fields of the engine that a protocol stands for."""
    ale, skips = protocol.order == "ale", protocol.order == "baselines"
    unit = "skip" if skips else "frame"
    return SimpleNamespace(
        players=players,
        repeat_action_probability=protocol.repeat_action_probability,
        seeding="ale" if ale else "gymnasium",
        frameskip=protocol.frame_skip,
        noops=protocol.noops,
        fire="after_noops" if skips and protocol.fire != "never" else protocol.fire,
        fire_counts=protocol.fire_counts and not (ale and protocol.fire == "never"),
        third_action=protocol.third_action,
        fire_unit=unit,
        fire_again=not ale,
        episodic_life=protocol.episodic_life,
        lives_unit=unit,
        on_reset=protocol.on_reset,
        last_life=protocol.last_life,
        seamless_lives=protocol.seamless_lives and not skips,
        life_loss_info=protocol.life_loss_info,
        max_frames=protocol.max_frames,
        max_episode_steps=None,
        max_num_frames_per_episode=protocol.max_num_frames_per_episode or None,
        reward_clipping=protocol.clip_reward,
        img_height=img_height,
        img_width=img_width,
        stack_num=stack_num,
        maxpool=protocol.max_pool,
        padding=protocol.padding,
        end_frames=protocol.end_frames,
    )
