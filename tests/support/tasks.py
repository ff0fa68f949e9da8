"""Tasks for the tests of wrappers."""

from typing import Any

from atari import Task
from atari.env import AtariEnv
from atari.registry.making import make_env
from atari.task.task import look_up
from atari.wrappers.layers import wrap


def nested(task: Task, core: str = "native", render_mode: Any = None) -> Any:
    """A single environment of the wrappers of a task, one in the other: the oracle of `EpisodeEnv` and of vectors."""
    if not task.preprocessed:
        return make_env(task, render_mode, core)
    env = wrap(AtariEnv(task.emulator_task(), core=core, render_mode=render_mode), task, nested=True)
    env.unwrapped.whole_task = task  # type: ignore[attr-defined]
    return env


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
    return look_up(game).task(None, {}, {**_IMAGES, **fields})


ALE: dict[str, Any] = {
    "noops": (0, 29),
    "fire": "before_noops",
    "fire_counts": True,
    "fire_again": False,
    "seeding": "ale",
    "end_frames": "gymnasium",
}
"""Fields of ale-py's vector environment."""
