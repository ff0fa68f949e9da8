"""`atari.sb3.AtariVecEnv` takes or refuses every field of a task, and plays what the documents say."""

import pytest
from documents import page
from doors import STABLE_BASELINES, check_cell, row

from atari.task.resolution import OPTIONS

pytestmark = pytest.mark.peers


@pytest.mark.parametrize("field", OPTIONS)
def test_a_vector_of_stable_baselines_takes_or_refuses_a_field(field: str) -> None:
    check_cell(STABLE_BASELINES, field)


def test_the_documents_say_what_it_plays() -> None:
    assert row(STABLE_BASELINES) in page("tasks.md")
