"""The settings of the vector engine, made from a protocol."""

from typing import Any, TypeVar

from atari import _emulator
from atari.cores.native import as_ale_reads
from atari.protocols import Protocol

NO_LIMIT = 2**31 - 1

_Settings = TypeVar("_Settings")


def filled(settings: _Settings, **fields: Any) -> _Settings:
    """A settings object of the engine with these fields set."""
    for name, value in fields.items():
        setattr(settings, name, value)
    return settings


def episode_settings(protocol: Protocol, players: int = 1) -> _emulator.EpisodeSettings:
    """The settings of how the engine begins, plays and ends episodes, of games of one or of several players."""
    kind = protocol.order if players == 1 else "multiplayer"
    return filled(
        _emulator.EpisodeSettings(),
        kind=_emulator.EpisodeKind[kind.upper()],
        players=players,
        repeat_action_probability=as_ale_reads(protocol.repeat_action_probability),
        max_num_frames_per_episode=protocol.max_num_frames_per_episode,
        frame_skip=protocol.frame_skip,
        noops=protocol.noops,
        fire_counts=protocol.fire_counts,
        fire=_emulator.FirePress[protocol.fire.upper()],
        episodic_life=protocol.episodic_life,
        life_loss_info=protocol.life_loss_info,
        on_reset=_emulator.OnReset[protocol.on_reset.upper()],
        last_life=protocol.last_life,
        seamless_lives=protocol.seamless_lives,
        clip_reward=protocol.clip_reward,
        max_frames=NO_LIMIT if protocol.max_frames is None else protocol.max_frames,
    )


def observation_settings(
    protocol: Protocol, pixels: _emulator.PixelFormat, height: int, width: int, stack: int
) -> _emulator.ObservationSettings:
    """The settings of how the engine pools, resizes and stacks frames."""
    return filled(
        _emulator.ObservationSettings(),
        pixels=pixels,
        height=height,
        width=width,
        stack=stack,
        max_pool=protocol.max_pool,
        end_frames=_emulator.EndFrames[protocol.end_frames.upper()],
        pads_zero=protocol.padding == "zero",
    )
