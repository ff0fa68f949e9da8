"""Helpers for users' environments."""

from gymnasium.utils import EzPickle, colorize

from atari.classic.utils import atomic_write, closer, json_utils, seeding
from atari.classic.utils.reraise import reraise

__all__ = ["EzPickle", "atomic_write", "closer", "colorize", "json_utils", "reraise", "seeding"]
