"""Random tasks for Hypothesis: every field, in combinations that `Task` accepts."""

from typing import Any

from hypothesis import reject
from hypothesis import strategies as st

from atari.task import Task
from atari.task.rules import settle
from atari.task.task import DEFAULTS

VALUES: dict[str, tuple[Any, ...]] = {
    "mode": (None,),
    "difficulty": (None,),
    "players": (1,),
    "actions": ("minimal", "full", ("NOOP", "FIRE", "UP", "LEFT"), ("UP", "NOOP"), ("DOWN",)),
    "continuous": (False, False, False, True),
    "continuous_action_threshold": (0.5, 0.2),
    "repeat_action_probability": (0.0, 0.25),
    "frameskip": (1, 2, 3, 4, (2, 5), (1, 3)),
    "noops": ((0, 0), (1, 8), (3, 3), (0, 5)),
    "fire": ("never", "before_noops", "after_noops"),
    "fire_counts": (False, True),
    "third_action": (False, True),
    "fire_unit": ("frame", "skip"),
    "fire_again": (True, False),
    "seeding": ("gymnasium", "ale"),
    "episodic_life": (False, True, True),
    "lives_unit": ("frame", "skip"),
    "on_reset": ("noop", "continue", "new_game"),
    "last_life": (False, True),
    "seamless_lives": (False, True),
    "life_loss_info": (False, False, True),
    "max_num_frames_per_episode": (108_000, None, 200, 90),
    "max_frames": (None, 150, 61),
    "max_episode_steps": (None, None, 25, 40),
    "obs_type": ("rgb", "grayscale", "ram", "dict", "rgb_dict"),
    "img_height": (None, 84, 60),
    "img_width": (None, 84, 50),
    "stack_num": (None, 1, 2, 4),
    "maxpool": (False, True),
    "pool_rgb": (False, True),
    "padding": ("zero", "reset"),
    "end_frames": ("last", "gymnasium", "baselines", "envpool"),
    "reward": (None, None, "reward - 5 * lives_lost + 0.1 * (ram[0x90] - before.ram[0x90])"),
    "reward_clipping": (False, True),
}
"""The values that are drawn for each field. Several players and sound have their own tests."""


def accepted(fields: dict[str, Any]) -> Task:
    """The task of drawn fields, without fields that have no effect; contradictory fields are rejected."""
    if fields["img_height"] is None or fields["img_width"] is None:
        fields["img_height"] = fields["img_width"] = None
    settle(fields, DEFAULTS, given=())
    try:
        return Task(**fields)
    except ValueError:
        reject()


@st.composite
def tasks(draw: st.DrawFn, games: tuple[str, ...]) -> Task:
    """A random task of one of these games."""
    fields: dict[str, Any] = {**DEFAULTS, **{name: draw(st.sampled_from(values)) for name, values in VALUES.items()}}
    fields["game"] = draw(st.sampled_from(games))
    return accepted(fields)
