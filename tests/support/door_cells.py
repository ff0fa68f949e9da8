"""The cells of the table of doors and fields: each door with a value of each field."""

from typing import Any

import pytest
from doors import Door

from atari.task import Task

PLAYERS = {"game": "pong", "players": 2, "obs_type": "grayscale"}
LIVES = {"episodic_life": True, "frameskip": 4}
FIRE = {"fire": "after_noops"}
VALUES: dict[str, tuple[dict[str, Any], Any]] = {
    "mode": ({}, 4),
    "difficulty": ({}, 1),
    "players": ({"game": "pong"}, 2),
    "actions": ({}, "full"),
    "continuous": ({}, True),
    "continuous_action_threshold": ({"continuous": True}, 0.75),
    "repeat_action_probability": ({}, 0.125),
    "frameskip": ({}, (2, 5)),
    "interventions": ({}, ["strong_ball"]),
    "noops": ({}, (5, 9)),
    "fire": ({}, "after_noops"),
    "fire_counts": ({**FIRE, "noops": (4, 4)}, True),
    "third_action": (FIRE, True),
    "fire_unit": (FIRE, "skip"),
    "fire_again": ({"fire": "before_noops", "noops": (1, 30)}, False),
    "seeding": ({"noops": (0, 30)}, "ale"),
    "episodic_life": ({}, True),
    "lives_unit": (LIVES, "skip"),
    "on_reset": (LIVES, "continue"),
    "last_life": (LIVES, True),
    "seamless_lives": ({**LIVES, "on_reset": "continue"}, True),
    "life_loss_info": ({}, True),
    "max_num_frames_per_episode": ({}, 900),
    "max_frames": ({}, 800),
    "max_episode_steps": ({}, 20),
    "obs_type": ({}, "ram"),
    "img_height": ({"img_width": 84}, 60),
    "img_width": ({"img_height": 84}, 60),
    "stack_num": ({}, 2),
    "maxpool": ({}, True),
    "pool_rgb": ({"obs_type": "grayscale", "maxpool": True, "end_frames": "last"}, True),
    "padding": ({"stack_num": 4}, "reset"),
    "end_frames": ({}, "baselines"),
    "sound_obs": ({}, True),
    "agent_indicator": ({**PLAYERS, "stack_num": 1}, True),
    "reward": ({}, "reward - 5 * lives_lost"),
    "reward_clipping": ({}, True),
    "zero_sum": (PLAYERS, True),
}
"""For each field, the options that it needs to have an effect, and a value other than ALE's v5."""


SEVERAL: dict[str, Any] = {"interventions": ["lazy_enemy"], "mode": 9, "max_num_frames_per_episode": 900}
"""Values for games of two players, if they differ from the values for one player."""


def options_of(door: Door, field: str) -> dict[str, Any]:
    """Options, GAME among them, in which a field differs from its default."""
    others, value = VALUES[field]
    if door.games != "several":
        return {"game": "breakout", **others, field: value}
    needed = {} if others is PLAYERS and field == "zero_sum" else others
    return {"players": 2, **needed, "game": "pong", field: SEVERAL.get(field, value)}


def call(door: Door, options: dict[str, Any]) -> Task:
    """The task of a door."""
    options = dict(options)
    game = options.pop("game")
    if not door.takes_options:
        return door.task(Task.of(game, **options))
    return door.task(f"ALE/{game.title()}-v5" if door.games == "ids" else game, **options)


def check_cell(door: Door, field: str) -> None:
    """Check that a door takes a field, so that its task has the value, or refuses it with a sentence that names it."""
    options = options_of(door, field)
    if field in door.outside:
        assert getattr(call(door, options), field) == getattr(Task("pong"), field), door.outside[field]
        return
    if field in door.refuses:
        with pytest.raises((TypeError, ValueError)) as error:
            call(door, options)
        text = str(error.value).replace("-", "_")  # flags have hyphens
        assert any(name in text for name in {*options} - {"game"}), door.refuses[field]
        return
    played = call(door, options)
    assert getattr(played, door.translates.get(field, field)) == getattr(Task(**options), field)
