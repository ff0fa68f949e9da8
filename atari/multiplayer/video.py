"""A module of 0.2, whose name raises an error that says the new one."""

from typing import Any

from atari._renamed import missing


def __getattr__(name: str) -> Any:
    raise missing("atari.multiplayer.video", name)
