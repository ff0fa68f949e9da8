"""Every door takes or refuses every field of a task, and plays the GAME of the table in docs/tasks.md."""

import pytest
from documents import page
from doors import DOORS, Door, call, check_cell, row
from env_tools import needs_gymnasium_1

from atari.task.resolution import OPTIONS


@pytest.mark.parametrize("field", OPTIONS)
@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
def test_a_door_takes_or_refuses_a_field(door: Door, field: str) -> None:
    check_cell(door, field)


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
@needs_gymnasium_1
def test_the_documents_say_what_a_door_plays(door: Door) -> None:
    assert row(door) in page("tasks.md")


WITH_SKIP = [door for door in DOORS if "frameskip" not in door.refuses]


@pytest.mark.parametrize("door", WITH_SKIP, ids=lambda door: door.name)
def test_a_door_suggests_the_right_name(door: Door) -> None:
    with pytest.raises((TypeError, ValueError), match="frameskip"):
        call(door, {"game": "pong", "frame_skip": 3})


def test_what_a_door_refuses_is_an_option() -> None:
    assert all(set(door.refuses) <= set(OPTIONS) for door in DOORS)
