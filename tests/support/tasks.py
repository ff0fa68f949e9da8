"""Tasks for the tests of wrappers."""

from types import SimpleNamespace
from typing import Any

_DEFAULTS: dict[str, Any] = {
    "frameskip": 4,
    "noops": (0, 0),
    "fire": "never",
    "fire_counts": False,
    "third_action": False,
    "fire_unit": "frame",
    "fire_again": True,
    "seeding": "gymnasium",
    "episodic_life": False,
    "lives_unit": "frame",
    "on_reset": "new_game",
    "last_life": False,
    "seamless_lives": False,
    "life_loss_info": False,
    "max_frames": None,
    "max_episode_steps": None,
    "obs_type": "grayscale",
    "img_height": 84,
    "img_width": 84,
    "stack_num": 4,
    "maxpool": True,
    "pool_rgb": False,
    "padding": "zero",
    "end_frames": "last",
    "reward_clipping": False,
}


def task(**fields: Any) -> SimpleNamespace:
    """A task with these fields: frames of 4 pooled, resized and stacked, and nothing else unless `fields` have it."""
    unknown = fields.keys() - _DEFAULTS.keys()
    assert not unknown, f"a task has no {unknown}"
    return SimpleNamespace(**{**_DEFAULTS, **fields})


ALE: dict[str, Any] = {
    "noops": (0, 29),
    "fire": "before_noops",
    "fire_counts": True,
    "fire_again": False,
    "seeding": "ale",
    "end_frames": "gymnasium",
}
"""Fields of ale-py's vector environment."""
