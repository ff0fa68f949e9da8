"""OpenAI Gym 0.7.4, 0.17.3, 0.21.0 and 0.26.2, whose interface `atari.classic` has.

Their facts are read from their unpacked archives by syntax tree (`scripts/interfaces`), and kept in a text file.
"""

from collections import defaultdict
from dataclasses import replace
from pathlib import Path

from interfaces import archive
from interfaces import facts as facts_of
from interfaces.compare import Ours, accepts
from interfaces.facts import Fact, Versions
from interfaces.reasons import reasons

FILE = Path(__file__).parents[1] / "data" / "gym.txt"
VERSIONS = ("0.7.4", "0.17.3", "0.21.0", "0.26.2")
NEWEST = VERSIONS[-1]
OURS = Ours({"gym": "atari.classic"})

_PREFERRED = ("0.21.0", "0.17.3", "0.26.2", "0.7.4")
"""Which signature counts where versions contradict each other: that of the version that `gym.version` names."""

_HEADING = """The interface of OpenAI Gym: names and signatures, read from its archives by `scripts/interfaces --write`.
A fact ends with the versions that have it. Modules that `reasons.toml` excuses have their path alone."""


_FIVE_VALUES = frozenset({"seed", "options", "return_info", "render_mode"})
"""Parameters of 0.26's methods of environments: `reset(seed=0)` returned two values then, and `step` five. This is the
interface of Gymnasium, not that of `gym.version`."""


def facts(archives: Path | None = None) -> Versions:
    """The facts of all versions, from the archives DIR/VERSION/gym-VERSION/gym, or from the file."""
    if archives is None:
        return facts_of.read(FILE)
    return _agreed(facts_of.merge({each: archive.read(archives / each / f"gym-{each}" / "gym") for each in VERSIONS}))


def write(archives: Path) -> None:
    """Keep the facts of the archives in the file."""
    found = facts(archives)
    excused = reasons("gym")
    kept = {
        fact: found[fact]
        for fact in found
        if fact.kind == "module" or not any(each.excuses(Fact(fact.module, "", "module")) for each in excused)
    }
    facts_of.write(FILE, _HEADING, kept)


def _agreed(found: Versions) -> Versions:
    """Without the signatures that contradict those of a preferred version."""
    found = {_of_four_values(fact) if versions == (NEWEST,) else fact: versions for fact, versions in found.items()}
    found = {_as_step_of_env(fact): versions for fact, versions in found.items()}
    signatures: dict[str, list[Fact]] = defaultdict(list)
    for fact in found:
        if fact.kind in ("function", "method"):
            signatures[fact.path].append(fact)
    dropped = set()
    for several in signatures.values():
        chosen, *others = sorted(several, key=lambda fact: min(_PREFERRED.index(each) for each in found[fact]))
        one = facts_of.signature(chosen.text)
        for fact in others:
            other = facts_of.signature(fact.text)
            if accepts(other, one) is not None and accepts(one, other) is not None:
                dropped.add(fact)
    return {fact: versions for fact, versions in found.items() if fact not in dropped}


def _of_four_values(fact: Fact) -> Fact:
    """A method of an environment of 0.26 without the parameters that `_FIVE_VALUES` names."""
    if fact.kind != "method" or fact.module.startswith("gym.spaces"):
        return fact
    signature = facts_of.signature(fact.text)
    kept = [each for name, each in signature.parameters.items() if name not in _FIVE_VALUES]
    return replace(fact, text=facts_of.plain(signature.replace(parameters=kept)))


def _as_step_of_env(fact: Fact) -> Fact:
    """A `step` with the name that its parameter has in `Env`: Gym's environments named it as they liked."""
    is_step = fact.kind == "method" and fact.name.endswith(".step") and fact.text in ("(a)", "(u)")
    return replace(fact, text="(action)") if is_step else fact
