"""The numbers of a `Task` are bounded, so that a task of a stranger allocates little; each error names its field."""

import json
from typing import Any, get_args

import numpy as np
import pytest
from field_values import CASES

import atari
from atari.task import Task
from atari.task.fields import GROUPS, ROWS, TYPES
from atari.task.resolution import OPTIONS

VALUES: tuple[Any, ...] = (10**6, 10**9, 2**63, -1, True, 1.5, None, "x", [])

NUMBERS = {
    name: {*get_args(TYPES[name])} or {TYPES[name]}
    for name in OPTIONS
    if {int, float, tuple[int, int]} & ({*get_args(TYPES[name])} | {TYPES[name]})
}
"""The fields of numbers, with their types."""


def takes(name: str, value: Any) -> bool:
    """Whether a field of a number takes one of `VALUES`: None, or a limit that is a large number."""
    return (value is None and type(None) in NUMBERS[name]) or (name in GROUPS["limits"] and value in (10**6, 10**9))


@pytest.mark.parametrize("name", NUMBERS)
def test_values(name: str) -> None:
    others = {other: value for other, value in CASES[name].needs.items() if other != "game"}
    if name == "max_frames":
        others["max_num_frames_per_episode"] = None
    for value in VALUES:
        fields = {**others, name: value}
        stored = json.dumps({**json.loads(Task("breakout").to_json()), **fields})
        if value is None and (others or ROWS[name].accepts):
            continue  # one of two fields that go together, or an option that is not given
        if takes(name, value):
            task = Task.of("breakout", **fields)
            assert Task.from_json(task.to_json()) == task
            continue
        with pytest.raises((TypeError, ValueError), match=f"{name}|probability range"):
            Task.of("breakout", **fields)
        with pytest.raises(ValueError, match=name):
            Task.from_json(stored)
        with pytest.raises((TypeError, ValueError), match=name):
            atari.AtariVectorEnv("breakout", 2, **fields)


def test_the_largest_observation_is_small() -> None:
    task = Task.of("breakout", stack_num=256)
    assert int(np.prod(atari.make(task).observation_space.shape or ())) < 32 << 20
    with pytest.raises(ValueError, match=r"stack_num must be within 1\.\.256, got 257"):
        Task.of("breakout", stack_num=257)
