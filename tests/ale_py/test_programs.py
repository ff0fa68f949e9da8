"""Programs for ale-py's raw interface see the same with `atari.ale_py` in its place."""

import ale_py
import pytest
from ale_py_programs import PROGRAMS, Program, digest
from env_tools import needs_new_ale_py

import atari.ale_py

pytestmark = needs_new_ale_py


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.__name__)
def test_a_program_sees_the_same(program: Program) -> None:
    assert digest(program, atari.ale_py) == digest(program, ale_py)
