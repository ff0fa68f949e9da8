"""The same arrays as ale-py's vector environment, to the byte."""

import json

import pytest
from vector.ale_vector import CASES, FILE, difference, sums

SUMS = json.loads(FILE.read_text())
PLAYED_AGAIN = [*list(CASES)[5:104:26], *list(CASES)[104::7]]
"""Some of each kind that ale-py plays again: the check sums in the file are its own."""


def test_all_cases_have_check_sums() -> None:
    assert list(SUMS) == list(CASES)


@pytest.mark.parametrize("name", CASES)
def test_equal_to_ale_py(name: str) -> None:
    case = CASES[name]
    found = sums(case, "native")
    assert found == SUMS[name], difference(case) or f"{name}: the file has other sums than ale-py"
    assert found[1] >= case.ends


@pytest.mark.parametrize("name", PLAYED_AGAIN)
def test_ale_py_has_these_check_sums(name: str) -> None:
    assert sums(CASES[name], "ale") == SUMS[name]
