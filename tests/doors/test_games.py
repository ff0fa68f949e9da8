"""Every door plays what GAME says, as the table in docs/tasks.md has it."""

import pytest
from documents import page
from doors import DOORS, Door, row
from env_tools import needs_gymnasium_1


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
@needs_gymnasium_1
def test_the_documents_say_what_a_door_plays(door: Door) -> None:
    assert row(door) in page("tasks.md")
