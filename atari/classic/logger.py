"""`gym.logger.set_level(40)`: how much is said on stderr."""

import sys
from functools import cache

from gymnasium import logger as _logger
from gymnasium.logger import error, warn

DEBUG, INFO, WARN, ERROR, DISABLED = 10, 20, 30, 40, 50

__all__ = ["DEBUG", "DISABLED", "ERROR", "INFO", "WARN", "error", "setLevel", "set_level", "warn"]


def set_level(level: int) -> None:
    """Say only what is of this level or above; 40 keeps warnings quiet."""
    _logger.min_level = level


setLevel = set_level  # as it was called before 2018


@cache
def say_once(text: str) -> None:
    """Say a line that the rest of the process need not hear again."""
    if _logger.min_level <= WARN:  # not `warn`, which makes three lines of it
        print(f"atari.classic: {text}", file=sys.stderr)
