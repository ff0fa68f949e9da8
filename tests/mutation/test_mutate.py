"""The mutants of small files: what is changed, and what is left alone."""

import ast
from pathlib import Path

import pytest
from mutation import mutate
from mutation.mutate import mutants


def changed(text: str, suffix: str) -> set[tuple[str, str]]:
    """The mutants of a text as pairs of kind and new text."""
    return {(each.kind, each.apply(text)) for each in mutants(f"a.{suffix}", text)}


PYTHON = '''
def f(a: int | None = 3) -> int:
    """A docstring with 1 < 2."""
    check(a)
    if a < 2 and b:
        raise ValueError(f"{a}")
    return a + 1  # not 5
'''


def test_python() -> None:
    expected = [
        ("constant", "= 3)", "= 4)"),
        ("deleted call", "check(a)", "pass"),
        ("operator", "a < 2", "a <= 2"),
        ("constant", "< 2 and", "< 3 and"),
        ("operator", " and ", " or "),
        ("condition", "a < 2 and b", "(not (a < 2 and b))"),
        ("deleted call", 'raise ValueError(f"{a}")', "pass"),
        ("operator", "a + 1", "a - 1"),
        ("constant", "+ 1", "+ 2"),
    ]
    assert changed(PYTHON, "py") == {(kind, PYTHON.replace(old, new)) for kind, old, new in expected}


def test_python_mutants_can_be_parsed() -> None:
    text = Path(mutate.__file__).read_text(encoding="utf-8")
    found = mutants("a.py", text)
    assert len(found) > 50
    for each in found:
        ast.parse(each.apply(text))


CPP = """
#include "a.hpp"  // 1
template <typename T>
void f(const T& a, int b) {
    static_assert(sizeof(T) == 4, "1 < 2");
    begin(a);
    if (b < 3 && a) throw std::invalid_argument("b < 4");
    for (int i = 0; i < b; ++i) total += i * 2;
    const char* text = "5";
}
"""


def test_cpp() -> None:
    expected = [
        ("deleted call", "begin(a);", ";"),
        ("operator", "b < 3", "b <= 3"),
        ("constant", "< 3", "< 4"),
        ("operator", "&& a", "|| a"),
        ("condition", "b < 3 && a", "!(b < 3 && a)"),
        ("deleted call", 'throw std::invalid_argument("b < 4");', ";"),
        ("constant", "i = 0", "i = 1"),
        ("operator", "i < b", "i <= b"),
        ("operator", "+= i", "-= i"),
        ("operator", "i * 2", "i + 2"),
        ("constant", "* 2", "* 3"),
    ]
    assert changed(CPP, "cpp") == {(kind, CPP.replace(old, new)) for kind, old, new in expected}


@pytest.mark.parametrize("text", ["x = 1\ny: int = z\n", "é = 1; print(é + 2)\n"])
def test_descriptions_name_the_line(text: str) -> None:
    for each in mutants("a.py", text):
        assert each.describe(text).startswith(f"a.py:1 ({each.kind}) ")
