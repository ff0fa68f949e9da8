"""Helpers for users' environments."""

from types import ModuleType

from gymnasium.utils import EzPickle, colorize

from atari.classic.utils import seeding
from atari.classic.utils.reraise import reraise

__all__ = ["EzPickle", "atomic_write", "closer", "colorize", "json_utils", "reraise", "seeding"]

atomic_write: ModuleType
closer: ModuleType
json_utils: ModuleType
"""Modules of Gym, of the table in `gym_modules`."""
