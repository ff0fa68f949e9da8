"""`atari.classic` has the interface of OpenAI Gym, and the comparison finds what would be missing."""

import re
from collections import Counter
from functools import cache, partial
from pathlib import Path

import pytest

from interfaces import archive, facts
from interfaces.__main__ import table
from interfaces.compare import Ours, accepts, check, compare
from interfaces.facts import Fact, merge, signature
from interfaces.peers.gym import FILE
from interfaces.reasons import Reason, tabulate

gym_table = cache(partial(table, "gym"))

PAGE = Path(__file__).parents[2] / "docs" / "classic.md"

SOURCE = '''
from enum import Enum

try:
    from elsewhere import lost
except ImportError:
    lost = None

LEVEL, _HIDDEN = 3, 4

class Base:
    def run(self, start, *, end=LEVEL):
        self._before(start)
        return self.after()

    def _before(self, start): ...
    def _unused(self): ...

class Recorder(Base):
    """A subclass."""
    suffix = ".txt"

    def __init__(self, path, mode="w", **options):
        self.path, self._file = path, None

    def after(self): ...

    @property
    def name(self): ...

    @staticmethod
    def default(n=3): ...

def load(path, /, flag=False, *paths): ...
'''


@pytest.fixture
def package(tmp_path: Path) -> Path:
    folder = tmp_path / "thing"
    (folder / "tests").mkdir(parents=True)
    (folder / "tests" / "__init__.py").write_text("secret = 1")
    (folder / "__init__.py").write_text("from .tools import Recorder\nimport os")
    (folder / "tools.py").write_text(SOURCE)
    (folder / "old.py").write_text("raise ValueError, 'Python 2'")
    return folder


def test_gym_has_nothing_that_is_missing_without_a_reason() -> None:
    found = gym_table()
    assert not found.fails, f"\n{found}"


def test_the_page_has_the_numbers() -> None:
    page = PAGE.read_text(encoding="utf-8")
    assert f"These are {len(facts.read(FILE)):,} facts" in page
    counts = Counter[str]()
    for reason, differences in gym_table().by_reason.items():
        counts[str(reason).partition(":")[0]] += len(differences)
    rows = re.findall(r"^\| (belongs|removed) .*\| (\d+) \|$", page, re.MULTILINE)
    assert sorted(int(number) for _, number in rows) == sorted(counts.values())


def test_facts_of_an_archive(package: Path) -> None:
    lines = {str(fact).replace("thing.tools.", "") for fact in archive.read(package)}
    assert lines == {
        "module thing", "module thing.tools", "module thing.old", "value thing.Recorder",
        "value LEVEL", "class Base", "class Recorder", "base Recorder thing.tools.Base".replace("thing.tools.", ""),
        "method Base.run(start, *, end=...)", "hook Base._before", "method Base._before(start)",
        "method Recorder.__init__(path, mode='w', **options)", "method Recorder.after()",
        "method Recorder.default(n=3)", "attribute Recorder.path", "attribute Recorder.suffix",
        "attribute Recorder.name", "function load(path, /, flag=False, *paths)",
    }  # fmt: skip


def test_facts_are_kept_in_a_text_file(package: Path, tmp_path: Path) -> None:
    both = merge({"1.0": archive.read(package), "2.0": [Fact("thing", "", "module")]})
    facts.write(tmp_path / "facts.txt", "a heading\nof two lines", both)
    assert facts.read(tmp_path / "facts.txt") == both
    assert both[Fact("thing", "", "module")] == ("1.0", "2.0")


@pytest.mark.parametrize(
    ("theirs", "ours", "problem"),
    [
        ("(a, b=1)", "(a, b=1, c=2)", None),
        ("(a, b=1)", "(a, *, b=1)", "no b by position"),
        ("(a, b=1)", "(a, c=1)", "argument 2 is c, not b"),
        ("(a)", "(a, b)", "b is required"),
        ("(a, b=1)", "(a, b=2)", "b is 2 by default, not 1"),
        ("(a=None)", "(a)", "a has no default"),
        ("(a, *, b=1)", "(a, b=1)", None),
        ("(a, **k)", "(a)", "no **k"),
        ("(*a, **k)", "()", None),
        ("(a, b=1)", "(*a, **k)", None),
        ("(a, /)", "(b)", None),
        ("(a=f())", "(a=3)", None),
    ],
)
def test_which_signatures_are_accepted(theirs: str, ours: str, problem: str | None) -> None:
    assert accepts(signature(theirs), signature(ours)) == problem


@pytest.mark.parametrize(
    ("fact", "what"),
    [
        (Fact("gym.wrappers.nothing", "", "module"), "missing"),
        (Fact("gym.wrappers.monitor", "Monitor._nothing", "hook"), "a subclass's method is not called"),
        (Fact("gym.wrappers.monitor", "Monitor._video_enabled", "hook"), None),
        (Fact("gym.wrappers.monitor", "Monitor.nothing", "attribute"), "missing"),
        (Fact("gym.wrappers.monitor", "Monitor.videos", "attribute"), None),
        (Fact("gym.wrappers.monitor", "Monitor", "base", "gym.core.ActionWrapper"), "not derived from gym.core.ActionWrapper"),
        (Fact("gym.spaces.utils", "flatdim", "function", "(n)"), "argument 1 is space, not n in (space)"),
        (Fact("gym.envs.classic_control.acrobot", "AcrobotEnv._terminal", "hook"), None),  # of the adapted class
    ],
)  # fmt: skip
def test_what_a_fact_lacks_here(fact: Fact, what: str | None) -> None:
    assert check(fact, Ours({"gym": "atari.classic"})) == what


def test_a_reason_must_hold() -> None:
    there = merge({"1": [Fact("gym.a", "", "module"), Fact("gym.b", "", "module")], "2": [Fact("gym.b", "", "module")]})
    reason = Reason("gym", "removed upstream before 2", ("gym.a", "gym.b", "gym.c"))
    found = tabulate(compare(there, Ours({"gym": "atari.classic"})), [reason], there, newest="2")
    assert (found.unused, found.wrong, found.fails) == (("gym.c",), ("gym.b",), True)
    assert tabulate([], [], there).fails is False
