"""`gym.logger`: warnings on stderr, and the least level that is printed."""

import sys
from functools import cache
from types import ModuleType
from typing import Any

from gymnasium import logger as _logger
from gymnasium.logger import deprecation, error, warn

DEBUG, INFO, WARN, ERROR, DISABLED = 10, 20, 30, 40, 50

__all__ = [
    "DEBUG",
    "DISABLED",
    "ERROR",
    "INFO",
    "WARN",
    "debug",
    "deprecation",
    "error",
    "info",
    "setLevel",
    "set_level",
    "warn",
]


class _Logger(ModuleType):
    """This module, whose level is Gymnasium's, under both of its names in Gym."""

    @property
    def min_level(self) -> int:
        """The least level that is printed; a script may assign it."""
        return _logger.min_level

    @min_level.setter
    def min_level(self, level: int) -> None:
        _logger.min_level = level

    MIN_LEVEL = min_level


sys.modules[__name__].__class__ = _Logger


def set_level(level: int) -> None:
    """Print only messages of this level or above; 40 suppresses warnings."""
    _logger.min_level = level


setLevel = set_level  # its name before 2018


def debug(msg: str, *args: Any) -> None:
    """Print a message of level 10."""
    _print(DEBUG, msg, args)


def info(msg: str, *args: Any) -> None:
    """Print a message of level 20."""
    _print(INFO, msg, args)


def _print(level: int, msg: str, args: tuple[Any, ...]) -> None:
    if _logger.min_level <= level:
        print({DEBUG: "DEBUG", INFO: "INFO"}[level] + ": " + (msg % args if args else msg))


@cache
def warn_once(text: str) -> None:
    """Print a warning in one line, once in a process."""
    if _logger.min_level <= WARN:  # not `warn`, which prints three lines
        print(f"atari.classic: {text}", file=sys.stderr)


def undo_logger_setup() -> None:
    """Return without a change: Gym set up Python's logging until 2017, and this package does not."""
