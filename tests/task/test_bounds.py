"""The numbers of a `Task` are bounded, so that a task of a stranger allocates little; each error names its field."""

import json
from typing import Any

import numpy as np
import pytest

import atari
from atari.task import Task
from atari.task.fields import FIELDS

VALUES: tuple[Any, ...] = (10**6, 10**9, 2**63, -1, True, 1.5, None, "x", [])

TAKES: dict[str, tuple[Any, ...]] = {
    "mode": (None,),
    "difficulty": (None,),
    "players": (None,),
    "continuous_action_threshold": (),
    "repeat_action_probability": (None,),
    "frameskip": (),
    "noops": (),
    "max_num_frames_per_episode": (10**6, 10**9, None),
    "max_frames": (10**6, 10**9, None),
    "max_episode_steps": (10**6, 10**9, None),
    "img_height": (None,),
    "img_width": (None,),
    "stack_num": (None,),
}
"""Those of `VALUES` that a field of a number takes."""

NOT_GIVEN = ("players", "repeat_action_probability")
"""Fields whose value None is no value, as in ale-py."""

WITH: dict[str, dict[str, Any]] = {
    "max_frames": {"max_num_frames_per_episode": None},
    "img_height": {"img_width": 84},
    "img_width": {"img_height": 84},
    "continuous_action_threshold": {"continuous": True},
}
"""Other fields, so that a field has an effect."""


def same(one: Any, other: Any) -> bool:
    return type(one) is type(other) and one == other


def test_every_field_of_a_number_is_here() -> None:
    numbers = {name for name in FIELDS if isinstance(getattr(Task("pong"), name), (int, float, tuple))}
    numbers -= {name for name in FIELDS if isinstance(getattr(Task("pong"), name), bool)} | {"interventions"}
    assert numbers | {"img_height", "img_width", "stack_num", "max_frames", "max_episode_steps"} == {*TAKES}


@pytest.mark.parametrize("name", TAKES)
def test_values(name: str) -> None:
    others = WITH.get(name, {})
    for value in VALUES:
        fields = {**others, name: value}
        stored = json.dumps({**json.loads(Task("breakout").to_json()), **fields})
        if value is None and name in NOT_GIVEN:
            continue
        if any(same(value, one) for one in TAKES[name]) and not (value is None and others):
            task = Task.of("breakout", **fields)
            assert Task.from_json(task.to_json()) == task
            continue
        if value is None and others:
            continue  # of two fields that go together
        with pytest.raises((TypeError, ValueError), match=f"{name}|probability range"):
            Task.of("breakout", **fields)
        with pytest.raises(ValueError, match=name):
            Task.from_json(stored)
        with pytest.raises((TypeError, ValueError), match=name):
            atari.AtariVectorEnv("breakout", 2, **fields)


def test_the_largest_observation_is_small() -> None:
    task = Task.of("breakout", stack_num=256)
    assert int(np.prod(task.make().observation_space.shape or ())) < 32 << 20
    with pytest.raises(ValueError, match=r"stack_num must be within 1\.\.256, got 257"):
        Task.of("breakout", stack_num=257)
