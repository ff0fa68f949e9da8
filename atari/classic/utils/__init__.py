"""Helpers for users' environments."""

from gymnasium.utils import EzPickle, colorize

from atari.classic.utils import seeding

__all__ = ["EzPickle", "colorize", "seeding"]
