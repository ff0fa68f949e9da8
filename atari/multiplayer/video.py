"""A module of 0.2, whose name raises an error that says the new one."""

from atari._renamed import old_names

__getattr__ = old_names("atari.multiplayer.video")
