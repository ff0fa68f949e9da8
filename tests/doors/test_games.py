"""Every door plays what GAME says, as the table in docs/tasks.md has it."""

import pytest
from documents import page
from doors import DOORS, Door, row


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
def test_the_documents_say_what_a_door_plays(door: Door) -> None:
    assert row(door) in page("tasks.md")
