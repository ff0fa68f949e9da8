"""The reasons for which a name of another package may be missing here."""

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from interfaces.compare import Difference
from interfaces.facts import Fact, Versions

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

FILE = Path(__file__).parent / "data" / "reasons.toml"


@dataclass(frozen=True)
class Reason:
    """A reason, and the patterns of the paths that it excuses, with `*` for any text."""

    peer: str
    reason: str
    names: tuple[str, ...]

    def excuses(self, fact: Fact) -> str | None:
        """The pattern that the path of a fact, or its module or a package of it, matches."""
        parts = fact.module.split(".")
        paths = [fact.path, *(".".join(parts[:size]) for size in range(1, len(parts) + 1))]
        return next((name for name in self.names if any(fnmatchcase(each, name) for each in paths)), None)


def reasons(peer: str) -> list[Reason]:
    """The reasons for names of a peer, from the data file."""
    tables = tomllib.loads(FILE.read_text(encoding="utf-8"))["allowed"]
    return [Reason(each["peer"], each["reason"], tuple(each["names"])) for each in tables if each["peer"] == peer]


@dataclass(frozen=True)
class Table:
    """The differences of a peer by reason; those under None have no allowed reason."""

    by_reason: dict[str | None, list[Difference]]
    unused: tuple[str, ...]
    """Patterns that excuse nothing."""
    wrong: tuple[str, ...]
    """Names that are excused as removed upstream, and that the newest version has."""

    @property
    def fails(self) -> bool:
        """Whether something is missing without a reason, or a reason does not hold."""
        return bool(self.by_reason.get(None) or self.unused or self.wrong)

    def __str__(self) -> str:
        lines = [f"{'reason':<60} {'names':>6} {'signatures':>11} {'hooks':>6}"]
        for reason, differences in sorted(self.by_reason.items(), key=lambda each: str(each[0])):
            hooks = sum(each.fact.kind == "hook" for each in differences)
            names = sum(each.what == "missing" for each in differences)
            lines.append(f"{reason or 'NONE':<60} {names:>6} {len(differences) - names - hooks:>11} {hooks:>6}")
        lines += [f"  {each}" for each in self.by_reason.get(None, ())]
        lines += [f"the pattern {name!r} of the reasons excuses nothing; delete it" for name in self.unused]
        lines += [f"{name} is excused as removed upstream, and the newest version has it" for name in self.wrong]
        return "\n".join(lines)


def tabulate(differences: Iterable[Difference], allowed: Iterable[Reason], facts: Versions, newest: str = "") -> Table:
    """The differences by reason.

    Args:
        differences: those of one peer.
        allowed: its reasons.
        facts: all facts of the peer, to check the reason "removed upstream".
        newest: the version that must not have a name of this reason; empty checks nothing.
    """
    by_reason: dict[str | None, list[Difference]] = {}
    allowed = tuple(allowed)
    used: set[str] = set()
    wrong = []
    for each in differences:
        found = next(((reason, name) for reason in allowed if (name := reason.excuses(each.fact))), None)
        if found is None:
            by_reason.setdefault(None, []).append(each)
            continue
        used.add(found[1])
        by_reason.setdefault(found[0].reason, []).append(each)
        if found[0].reason.startswith("removed upstream") and newest in facts[each.fact]:
            wrong.append(each.fact.path)
    unused = tuple(name for reason in allowed for name in reason.names if name not in used)
    return Table(by_reason, unused, tuple(wrong))
