"""`atari train` takes or refuses every field of a task, and plays what the documents say."""

import pytest
from documents import page
from doors import TRAIN, check_cell, row

from atari.task.resolution import OPTIONS

pytest.importorskip("torch")


@pytest.mark.parametrize("field", OPTIONS)
def test_a_training_takes_or_refuses_a_field(field: str) -> None:
    check_cell(TRAIN, field)


def test_the_documents_say_what_a_training_plays() -> None:
    assert row(TRAIN) in page("tasks.md")
