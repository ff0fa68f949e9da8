"""What environments of a user's own were written with."""

from gymnasium.utils import EzPickle, colorize

from atari.classic.utils import seeding

__all__ = ["EzPickle", "colorize", "seeding"]
