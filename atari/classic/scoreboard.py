"""`gym.upload`: the last line of many scripts until 2017."""

from typing import Any

from atari.classic import logger


def upload(*_: Any, **__: Any) -> None:
    """Warn that the site for results is closed, and do nothing else; the files do not move."""
    logger.warn_once(
        "gym.upload() does nothing, as the site it went to is closed; the results are still in their folder"
    )
