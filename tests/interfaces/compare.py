"""Says which facts of another package do not hold for this one."""

import ast
import importlib
import inspect
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from types import ModuleType
from typing import Any

from interfaces import facts as facts_of
from interfaces.enumerations import compare_enumeration
from interfaces.facts import UNKNOWN, Fact

_KIND = inspect.Parameter


@dataclass(frozen=True)
class Difference:
    """A fact that does not hold here, and how it fails."""

    fact: Fact
    what: str

    def __str__(self) -> str:
        return f"{self.fact}: {self.what}"


@dataclass(frozen=True)
class Ours:
    """The modules of this package that stand for those of another.

    Args:
        renamed: our module, or class in a module, by the path that it stands for: {"gym": "atari.classic"}. The longest
            beginning of a path counts.
        instances: makes an instance of a class by the other package's path of the class. Without it, the attributes of
            instances are read from the source of our class.
    """

    renamed: Mapping[str, str]
    instances: Mapping[str, Callable[[], Any]] = field(default_factory=dict)

    def path(self, path: str) -> str:
        """Our path for a path of the other package."""
        parts = path.split(".")
        for size in range(len(parts), 0, -1):
            ours = self.renamed.get(".".join(parts[:size]))
            if ours is not None:
                return ".".join((ours, *parts[size:]))
        return path

    def find(self, path: str) -> Any:
        """Our object for a path; AttributeError or ImportError if there is none."""
        parts = self.path(path).split(".")
        for size in range(len(parts), 0, -1):
            found = _module(".".join(parts[:size]))
            if found is None:
                continue
            for part in parts[size:]:
                found = _member(found, part)
            return found
        raise ImportError(path)


@cache
def _module(name: str) -> ModuleType | None:
    """The module of a name; None if there is none."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not name.startswith(error.name):
            raise
        return None


def _member(owner: Any, name: str) -> Any:
    """The attribute of an object; of an adapter's class also that of the class which it adapts."""
    try:
        return getattr(owner, name)
    except AttributeError:
        if not inspect.isclass(getattr(owner, "original", None)):
            raise
    return getattr(owner.original, name)


def compare(facts: Mapping[Fact, tuple[str, ...]], ours: Ours) -> list[Difference]:
    """The facts that do not hold here; a name inside a missing module or class is not listed again."""
    differences: list[Difference] = []
    missing: set[str] = set()
    for fact in sorted(facts, key=lambda each: (each.path.count("."), each)):
        parents = [fact.path.rpartition(".")[0]] if fact.name else []
        parents += [fact.module, f"{fact.module}.{fact.name.partition('.')[0]}"] if "." in fact.name else [fact.module]
        if any(parent in missing for parent in parents if parent != fact.path or fact.kind == "base"):
            if fact.kind == "module":
                pass
            else:
                missing.add(fact.path)
                continue
        what = check(fact, ours)
        if what is not None:
            differences.append(Difference(fact, what))
            if what == "missing":
                missing.add(fact.path)
    return differences


def check(fact: Fact, ours: Ours) -> str | None:
    """How a fact fails here; None if it holds."""
    if fact.kind == "module":
        try:
            importlib.import_module(ours.path(fact.module))
        except ImportError:
            return "missing"
        return None
    owner, _, last = fact.path.rpartition(".")
    if fact.kind in ("attribute", "hook") or (fact.kind == "method" and last != "__init__"):
        try:
            kind = ours.find(owner)
        except (ImportError, AttributeError):
            return "missing"
        if fact.kind == "hook":
            return None if last in calls_on_self(kind) else "a subclass's method is not called"
        if fact.kind == "attribute":
            return None if _has_attribute(kind, last, ours.instances.get(owner)) else "missing"
    try:
        found = ours.find(owner if last == "__init__" else fact.path)
    except (ImportError, AttributeError):
        return "missing"
    if fact.kind == "class":
        return None if inspect.isclass(found) or callable(found) else f"a {type(found).__name__}, not a class"
    if fact.kind == "base":
        return _check_base(fact, found, ours)
    if last.startswith("__") and last not in ("__init__", "__call__"):
        return None  # Python calls it, by position
    if fact.kind == "enumeration":
        return compare_enumeration(fact.text, found)
    if fact.kind in ("function", "method") and fact.text:
        return _check_signature(fact, found, last, ours.path(owner))
    return None


def _check_base(fact: Fact, found: Any, ours: Ours) -> str | None:
    try:
        base = ours.find(fact.text)
    except (ImportError, AttributeError):
        return None  # listed by itself
    if inspect.isclass(found) and inspect.isclass(base) and not issubclass(found, base):
        return f"not derived from {fact.text}"
    return None


def _check_signature(fact: Fact, found: Any, last: str, owner: str) -> str | None:
    if not callable(found):
        return None if isinstance(found, property) else f"a {type(found).__name__}, which cannot be called"
    try:
        signature = inspect.signature(found)
    except (TypeError, ValueError):
        return None
    without_first = fact.kind == "method" and last != "__init__" and not inspect.ismethod(found)
    if without_first and isinstance(_static(owner, last), staticmethod):
        without_first = False
    text = facts_of.plain(signature, without_first=without_first)
    problem = accepts(facts_of.signature(fact.text), facts_of.signature(text))
    return None if problem is None else f"{problem} in {text}"


def _static(owner: str, name: str) -> Any:
    try:
        return inspect.getattr_static(Ours({}).find(owner), name)
    except (ImportError, AttributeError):
        return None


def accepts(theirs: inspect.Signature, ours: inspect.Signature) -> str | None:
    """Which call of their signature ours does not accept, or what it means instead; None if there is none."""
    if all(each.kind in (_KIND.VAR_POSITIONAL, _KIND.VAR_KEYWORD) for each in theirs.parameters.values()):
        return None  # (*args, **kwargs) says nothing of the calls
    own = dict(ours.parameters)
    by_position = [each for each in own.values() if each.kind in (_KIND.POSITIONAL_ONLY, _KIND.POSITIONAL_OR_KEYWORD)]
    any_position = any(each.kind is _KIND.VAR_POSITIONAL for each in own.values())
    any_keyword = any(each.kind is _KIND.VAR_KEYWORD for each in own.values())
    place = 0
    for each in theirs.parameters.values():
        if each.kind is _KIND.VAR_POSITIONAL:
            if not any_position:
                return f"no *{each.name}"
            continue
        if each.kind is _KIND.VAR_KEYWORD:
            if not any_keyword:
                return f"no **{each.name}"
            continue
        if each.kind in (_KIND.POSITIONAL_ONLY, _KIND.POSITIONAL_OR_KEYWORD):
            if place >= len(by_position):
                if not any_position:
                    return f"no {each.name} by position"
            elif by_position[place].name != each.name and each.kind is not _KIND.POSITIONAL_ONLY:
                return f"argument {place + 1} is {by_position[place].name}, not {each.name}"
            place += 1
        if each.kind is not _KIND.POSITIONAL_ONLY and each.name not in own:
            if not any_keyword:
                return f"no {each.name}"
            continue
        default = own[each.name].default if each.name in own else _KIND.empty
        if each.default is not _KIND.empty:
            if default is _KIND.empty and each.name in own:
                return f"{each.name} has no default"
            if UNKNOWN not in (default, each.default) and default != each.default and each.name in own:
                return f"{each.name} is {default!r} by default, not {each.default!r}"
    for each in own.values():
        required = each.default is _KIND.empty and each.kind not in (_KIND.VAR_POSITIONAL, _KIND.VAR_KEYWORD)
        given = each.kind is not _KIND.KEYWORD_ONLY and by_position.index(each) < place if required else True
        if not given and each.name not in theirs.parameters:
            return f"{each.name} is required"
    return None


def _has_attribute(kind: Any, name: str, make: Callable[[], Any] | None) -> bool:
    if hasattr(kind, name) or make is not None:
        return hasattr(kind, name) or hasattr(make(), name)  # type: ignore[misc]
    return inspect.isclass(kind) and name in set_on_self(kind)


@cache
def set_on_self(kind: type) -> frozenset[str]:
    """The attributes that the methods of one of our classes set on `self`, and those that it annotates."""
    names = {name for each in kind.__mro__ for name in inspect.get_annotations(each)}
    for tree in _sources(kind):
        for each in ast.walk(tree):
            if isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Store) and _is_self(each.value):
                names.add(each.attr)
    original = getattr(kind, "original", None)  # the environment whose attributes an adapter has
    return frozenset(names | (set_on_self(original) | set(dir(original)) if inspect.isclass(original) else set()))


@cache
def calls_on_self(kind: type) -> frozenset[str]:
    """The methods that the methods of one of our classes call on `self`, or hand on for a call.

    `self._call("step")` calls `_step`.
    """
    names = set()
    for tree in _sources(kind):
        for each in ast.walk(tree):
            if isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Load) and _is_self(each.value):
                names.add(each.attr)
            if isinstance(each, ast.Call) and ast.unparse(each.func) == "self._call":
                called = ast.literal_eval(each.args[0]) if isinstance(each.args[0], ast.Constant) else ""
                names |= {called, f"_{called}"}
    original = getattr(kind, "original", None)  # an adapter's subclass replaces the methods of what is adapted
    return frozenset(names | (calls_on_self(original) if inspect.isclass(original) else set()))


def _is_self(tree: ast.expr) -> bool:
    return isinstance(tree, ast.Name) and tree.id == "self"


def _sources(kind: type) -> list[ast.Module]:
    return [tree for each in kind.__mro__ if (tree := _source(each))]


@cache
def _source(kind: type) -> ast.Module | None:
    try:
        return ast.parse(textwrap.dedent(inspect.getsource(kind)))
    except (OSError, TypeError, SyntaxError):  # a class of Python, or of C++
        return None
