"""Tasks for the tests of wrappers."""

from typing import Any

from atari import Task
from atari.task.resolution import resolve_task

_IMAGES = {
    "repeat_action_probability": 0.0,
    "max_num_frames_per_episode": None,
    "obs_type": "grayscale",
    "img_height": 84,
    "img_width": 84,
    "stack_num": 4,
    "maxpool": True,
}


def task(game: str = "breakout", **fields: Any) -> Task:
    """A task with these fields: frames of 4 pooled, resized and stacked, and no other change unless `fields` have it.

    Fields without effect take their defaults.
    """
    return resolve_task(game, None, {}, base={**_IMAGES, **fields})


ALE: dict[str, Any] = {
    "noops": (0, 29),
    "fire": "before_noops",
    "fire_counts": True,
    "fire_again": False,
    "seeding": "ale",
    "end_frames": "gymnasium",
}
"""Fields of ale-py's vector environment."""
