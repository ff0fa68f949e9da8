"""`gym.logger`: warnings on stderr, and the least level that is printed."""

import sys
from functools import cache
from typing import Any

from gymnasium import logger as _logger
from gymnasium.logger import error, warn

DEBUG, INFO, WARN, ERROR, DISABLED = 10, 20, 30, 40, 50

__all__ = ["DEBUG", "DISABLED", "ERROR", "INFO", "WARN", "debug", "error", "info", "setLevel", "set_level", "warn"]


def set_level(level: int) -> None:
    """Print only messages of this level or above; 40 suppresses warnings."""
    _logger.min_level = level


setLevel = set_level  # its name before 2018


def debug(text: str, *values: Any) -> None:
    """Print a message of level 10."""
    _print(DEBUG, text, values)


def info(text: str, *values: Any) -> None:
    """Print a message of level 20."""
    _print(INFO, text, values)


def _print(level: int, text: str, values: tuple[Any, ...]) -> None:
    if _logger.min_level <= level:
        print({DEBUG: "DEBUG", INFO: "INFO"}[level] + ": " + (text % values if values else text))


@cache
def warn_once(text: str) -> None:
    """Print a warning in one line, once in a process."""
    if _logger.min_level <= WARN:  # not `warn`, which prints three lines
        print(f"atari.classic: {text}", file=sys.stderr)
