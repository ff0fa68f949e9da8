"""Public names of 0.2 that have others now: each raises an error that says the new one."""

from collections.abc import Mapping
from typing import Any

RENAMED: Mapping[str, str] = {
    "atari.Protocol": "atari.Task",
    "atari.protocols.Protocol": "atari.Task",
    "atari.multiplayer.PreprocessedEnv": "atari.multiplayer.MultiplayerEnv(game, preset='multiplayer_dqn')",
    "atari.multiplayer.video.record_game": "atari.recording.RecordMatch, whose replay `Replay.render` makes a video of",
    "atari.wrappers.preset_protocol": "atari.Task.of(game, preset=name)",
    "atari.Preset": "atari.task.presets.Preset",
    "atari.multiplayer.Environment": "atari.games.pettingzoo.Environment",
    "atari.wrappers.PRESETS": "atari.PRESETS",
    "atari.wrappers.LazyStack": "atari.wrappers.frame_stack.LazyStack",
    "AtariEnv.make_sound": "AtariEnv.driver.make_sound",
    "AtariEnv.observers": "AtariEnv.driver.observers",
    "AtariEnv.play_frames": "AtariEnv.driver.play_frames(action, frames=n)",
    "AtariEnv.play_until": "AtariEnv.driver.play_until(action, frames=n)",
}
"""The new name by the old one."""


def missing(module: str, name: str) -> Exception:
    """The error for an attribute that a module does not have.

    An old name gets an ImportError: the message of an AttributeError is lost in `from module import name`.
    """
    new = RENAMED.get(f"{module}.{name}")
    if new is None:
        return AttributeError(f"module {module!r} has no attribute {name!r}")
    return ImportError(f"{module}.{name} is now {new}; docs/from-0.2.md has all names that changed")


def missing_attribute(owner: Any, name: str) -> AttributeError:
    """The error for an attribute that an object does not have."""
    kind = type(owner).__name__
    new = RENAMED.get(f"{kind}.{name}")
    if new is None:
        return AttributeError(f"{kind!r} object has no attribute {name!r}")
    return AttributeError(f"{kind}.{name} is now {new}; docs/from-0.2.md has all names that changed")
