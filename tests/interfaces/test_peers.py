"""The interfaces of installed packages, and that the comparison finds what would be missing."""

import enum
import importlib.util
from typing import Any

import pytest
from env_tools import needs_gymnasium_1, needs_new_ale_py

from interfaces import live
from interfaces.__main__ import table
from interfaces.compare import Ours, compare
from interfaces.enumerations import compare_enumeration, describe
from interfaces.facts import Fact

_NEEDS = {"ale_py": needs_new_ale_py, "gymnasium": needs_gymnasium_1}
_OTHERS = ("multi_agent_ale_py", "envpool", "pettingzoo", "stable_baselines3")


@pytest.mark.parametrize(
    "peer",
    [
        *(pytest.param(peer, marks=mark) for peer, mark in _NEEDS.items()),
        *(pytest.param(peer, marks=pytest.mark.peers) for peer in _OTHERS),
    ],
)
def test_nothing_is_missing(peer: str) -> None:
    found = table(peer)
    assert not found.fails, str(found)


@pytest.mark.parametrize(
    ("doc", "signatures"),
    [
        ("f(self, action: int, strength: float = 1.0) -> int\nf(self, action: a.b.C) -> int", ["(action, strength=1.0)", "(action)"]),
        ("f(arg: str | os.PathLike, /) -> None", ["(arg, /)"]),
        ("f(self, arg0: str, arg1: bool, /) -> None", ["(arg0, arg1, /)"]),
        ("f(self) -> numpy.ndarray[dtype=uint8, shape=(128)]", ["()"]),
        ("f(self, /)", ["()"]),
        ("1. f(self: x.Y, buffer: ndarray[dtype=uint8, order='C', device='cpu'] = None) -> None", ["(buffer=None)"]),
        ("f(mode: str = 'Next, Step', size: K = <K.A: 1>)", ["(mode='Next, Step', size=...)"]),
        ("Does something (here).", []),
        (None, []),
    ],
)  # fmt: skip
def test_a_docstring_has_the_signatures_of_a_compiled_function(doc: str | None, signatures: list[str]) -> None:
    assert live.documented("f", doc) == signatures


def test_an_enumeration_is_compared_by_what_is_seen_of_it() -> None:
    two = {"A": 0, "B": 1}
    text = describe(enum.Enum("Plain", two))
    assert compare_enumeration(text, enum.Enum("Plain", two)) is None
    assert compare_enumeration(text, enum.Enum("More", {**two, "C": 2})) == "the members A, B, C, not A, B"
    assert "of A is" in str(compare_enumeration(text, enum.IntEnum("Plain", two)))
    assert compare_enumeration(text, int) == "no enumeration"


class Theirs:
    """A class with a property, a method and an attribute."""

    def __init__(self, size: int) -> None:
        self.size = size

    @property
    def name(self) -> str:
        """A name."""
        return "x"

    def run(self, speed: int = 1) -> None:
        """Run."""
        self.stop()

    def stop(self) -> None:
        """Stop."""


class Other:
    """A class that lacks most of these."""

    def __init__(self, size: int) -> None:
        self._size = size

    def run(self, pace: int = 1) -> None:
        """Run."""

    def stop(self) -> None:
        """Stop."""


def test_what_a_class_lacks_is_found() -> None:
    path = f"{__name__}.Theirs"
    facts = live.versions({*live.class_facts(path, Theirs(1)), *live.attributes_of_source(path)}, "1")
    assert compare(facts, Ours({})) == []
    lacking = compare(facts, Ours({path: f"{__name__}.Other"}))
    assert sorted((each.fact.name, each.fact.kind) for each in lacking) == [
        ("Theirs.name", "attribute"),
        ("Theirs.run", "method"),
        ("Theirs.size", "attribute"),
        ("Theirs.stop", "hook"),
    ]


def test_a_peer_that_is_not_installed_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from interfaces import __main__ as program

    def missing(peer: str, archives: Any = None) -> Any:
        live.require("package_without_a_file", "package==3")

    monkeypatch.setattr(program, "table", missing)
    monkeypatch.setattr("sys.argv", ["interfaces", "ale_py"])
    assert program.main() == 1
    assert "NOT COMPARED: package_without_a_file is not installed here" in capsys.readouterr().out
    assert importlib.util.find_spec("package_without_a_file") is None
    assert Fact("a", "b", "value") not in live.versions([], "1")
