"""Write `docs/public-names.txt`: the public names with their signatures, and the options of the commands.

A signature has no annotations, because a better type is no other interface. Names are read from the sources, so those
of optional parts are among them. CHANGELOG.md has the digest of the file, so no change of it goes unmentioned.

usage: python scripts/generate/public_names.py
"""

import argparse
import ast
import copy
import hashlib
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts/site"))
from public import MODULES, Definition, definitions, resolve  # noqa: E402

from atari.cli import _parser  # noqa: E402

FILE = ROOT / "docs/public-names.txt"


def text() -> str:
    """The file: a line for each public name, member of a class, command and option, each kind in alphabetical order."""
    names = {line for module in MODULES for found in definitions(module) for line in _lines(found)}
    return "\n".join([*sorted(names), *sorted(_options("atari", _parser(()))), ""])


def digest(names: str) -> str:
    """The digest of the file that CHANGELOG.md has."""
    return hashlib.sha256(names.encode()).hexdigest()[:12]


def _lines(found: Definition) -> Iterator[str]:
    home, _, defined = found.path.rpartition(".")
    resolved = resolve(home, defined)
    assert resolved is not None
    name, node = f"{found.page}.{found.name}", resolved[1]
    if isinstance(node, ast.FunctionDef):
        yield name + _signature(node, skipped=0)
    elif isinstance(node, ast.ClassDef):
        members = dict(_members(home, node))
        yield name + members.pop("__init__", "")
        yield from (f"{name}.{member}{signature}" for member, signature in members.items())
    else:
        yield name


def _members(home: str, node: ast.ClassDef) -> Iterator[tuple[str, str]]:
    """The public members of a class with their signatures, after those of its bases in this package."""
    for base in reversed(node.bases):
        name = base.value if isinstance(base, ast.Subscript) else base
        found = resolve(home, name.id) if isinstance(name, ast.Name) else None
        if found and isinstance(found[1], ast.ClassDef):
            yield from _members(found[0], found[1])
    for each in node.body:
        if isinstance(each, ast.FunctionDef) and (each.name == "__init__" or not each.name.startswith("_")):
            decorators = {ast.unparse(decorator) for decorator in each.decorator_list}
            if any("property" in decorator or ".setter" in decorator for decorator in decorators):
                yield each.name, ""
            else:
                yield each.name, _signature(each, skipped="staticmethod" not in decorators)
        elif isinstance(each, ast.AnnAssign | ast.Assign):
            targets = [each.target] if isinstance(each, ast.AnnAssign) else each.targets
            value = f" = {ast.unparse(each.value)}" if isinstance(each, ast.AnnAssign) and each.value else ""
            names = [target.id for target in targets if isinstance(target, ast.Name)]
            yield from ((name, value) for name in names if not name.startswith("_"))


def _signature(function: ast.FunctionDef, skipped: int) -> str:
    """The parameters of a function without annotations and the first `skipped` ones."""
    arguments = copy.deepcopy(function.args)
    for each in ast.walk(arguments):
        if isinstance(each, ast.arg):
            each.annotation = None
    del (arguments.posonlyargs or arguments.args)[:skipped]
    return f"({ast.unparse(arguments)})"


def _options(command: str, of: argparse.ArgumentParser) -> Iterator[str]:
    """A line for each option and argument of a command and of the commands in it."""
    for action in of._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                yield from _options(f"{command} {name}", inner)
        elif action.help != argparse.SUPPRESS and action.dest != "help":
            yield f"{command} {', '.join(action.option_strings) or action.metavar or action.dest}"


if __name__ == "__main__":
    argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0]).parse_args()
    FILE.write_text(text(), encoding="utf-8")
    print(f"{FILE.name} has the digest {digest(text())}; CHANGELOG.md must have it, and a line on what changed")
