"""`Fact`: one statement about an interface, and the text file in which facts are kept."""

import ast
import inspect
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Kind = Literal["module", "class", "function", "value", "base", "method", "attribute", "hook", "enumeration"]


@dataclass(frozen=True, order=True)
class Fact:
    """One statement about an interface.

    `kind` says what `text` is:

    - "module": the module can be imported; `name` and `text` are empty.
    - "class": the module has this class. "base": `text` is the import path of a class that it derives from.
    - "function" and "method": `text` is the signature without `self`.
    - "value": another name of the module. "attribute": of a class or of its instances, set in `__init__`.
    - "hook": a method that the methods of the class call on `self`, so that a subclass may replace it.
    - "enumeration": `text` is what `enumerations.describe` says about all members.
    """

    module: str
    name: str  # "Monitor.step" for a method
    kind: Kind
    text: str = ""

    @property
    def path(self) -> str:
        """The dotted path of the name."""
        return f"{self.module}.{self.name}" if self.name else self.module

    def __str__(self) -> str:
        space = "" if self.kind in ("function", "method") else " "
        return f"{self.kind} {self.path}{space}{self.text}".rstrip()


Versions = Mapping[Fact, tuple[str, ...]]
"""Facts, each with the versions of the package for which it holds."""


def signature(text: str) -> inspect.Signature:
    """The signature that a text such as "(env, directory, force=False)" describes.

    A default that is no literal has the value `UNKNOWN`.
    """
    tree = ast.parse(f"def f{text}: pass").body[0]
    assert isinstance(tree, ast.FunctionDef)
    return of_arguments(tree.args)


class Unknown:
    """A default value that is no literal."""

    def __repr__(self) -> str:
        return "..."


UNKNOWN = Unknown()


def of_arguments(arguments: ast.arguments) -> inspect.Signature:
    """The signature of a function's syntax tree."""
    kind = inspect.Parameter
    by_position = [*arguments.posonlyargs, *arguments.args]
    missing = len(by_position) - len(arguments.defaults)
    parameters = []
    for i, each in enumerate(by_position):
        default = _literal(arguments.defaults[i - missing]) if i >= missing else kind.empty
        only = i < len(arguments.posonlyargs)
        parameters.append(kind(each.arg, kind.POSITIONAL_ONLY if only else kind.POSITIONAL_OR_KEYWORD, default=default))
    if arguments.vararg:
        parameters.append(kind(arguments.vararg.arg, kind.VAR_POSITIONAL))
    for each, tree in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True):
        parameters.append(kind(each.arg, kind.KEYWORD_ONLY, default=kind.empty if tree is None else _literal(tree)))
    if arguments.kwarg:
        parameters.append(kind(arguments.kwarg.arg, kind.VAR_KEYWORD))
    return inspect.Signature(parameters)


def plain(found: inspect.Signature, *, without_first: bool = False) -> str:
    """The text of a signature, without annotations, and with `...` for defaults that are no literals."""
    parameters = list(found.parameters.values())[1 if without_first else 0 :]
    return str(
        inspect.Signature(
            [each.replace(annotation=inspect.Parameter.empty, default=_default(each.default)) for each in parameters]
        )
    )


def _default(value: object) -> object:
    return value if value is inspect.Parameter.empty or _is_literal(value) else UNKNOWN


def _is_literal(value: object) -> bool:
    try:
        return bool(ast.literal_eval(repr(value)) == value)
    except (ValueError, SyntaxError):
        return False


def _literal(tree: ast.expr) -> object:
    try:
        value = ast.literal_eval(tree)
    except ValueError:
        return UNKNOWN
    return UNKNOWN if value is Ellipsis else value


def write(path: Path, heading: str, facts: Versions) -> None:
    """Write facts to a text file: a section for each module, a line for each fact, and its versions after `@`."""
    lines = [f"# {line}" for line in heading.splitlines()]
    for module in sorted({fact.module for fact in facts}):
        lines.append(f"\n[{module}]")
        for fact in sorted(fact for fact in facts if fact.module == module):
            statement = " ".join(filter(None, (fact.kind, fact.name, fact.text)))
            lines.append(f"{statement} @ {' '.join(facts[fact])}".replace(" @ ", " @ ").rstrip(" @"))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def read(path: Path) -> dict[Fact, tuple[str, ...]]:
    """The facts that `write` wrote."""
    facts: dict[Fact, tuple[str, ...]] = {}
    module = ""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            module = line[1:-1]
        elif line and not line.startswith("#"):
            statement, _, versions = line.partition(" @ ")
            kind, _, rest = statement.partition(" ")
            name, _, text = rest.partition(" ")
            facts[Fact(module, name, kind, text)] = tuple(versions.split())  # type: ignore[arg-type]
    return facts


def merge(versions: Mapping[str, Iterable[Fact]]) -> dict[Fact, tuple[str, ...]]:
    """The facts of several versions of a package, each with its versions in the order of the mapping."""
    merged: dict[Fact, tuple[str, ...]] = {}
    for version, facts in versions.items():
        for fact in facts:
            merged[fact] = (*merged.get(fact, ()), version)
    return merged
