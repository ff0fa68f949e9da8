"""`gym.upload`: what was the last line of scripts, until 2017."""

from typing import Any

from atari.classic import logger


def upload(*_: Any, **__: Any) -> None:
    """Do nothing but say so: the site that ranked results is closed. The results stay where they are."""
    logger.say_once(
        "gym.upload() does nothing, as the site it went to is closed; the results are still in their folder"
    )
