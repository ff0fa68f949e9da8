"""Helpers for environments that users write."""

from gymnasium.utils import EzPickle, colorize

from atari.classic.utils import seeding

__all__ = ["EzPickle", "colorize", "seeding"]
