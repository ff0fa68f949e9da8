"""Reads the interface of a package from its unpacked archive, by syntax tree: nothing of it runs."""

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path

from interfaces.facts import Fact, of_arguments, plain

_TESTS = ("test_", "tests")
_PROTOCOLS = frozenset(
    {"__del__", "__exit__", "__getattr__", "__new__", "__post_init__", "__repr__", "__setstate__", "__unicode__"}
)
"""Methods that Python calls; no script calls them by name or needs their signature."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def read(folder: Path) -> set[Fact]:
    """The facts of the package whose folder this is; its tests are left out."""
    modules = dict(_modules(folder))
    classes = {
        f"{name}.{each.name}": (name, each)
        for name, tree in modules.items()
        for each in _statements(tree.body)
        if isinstance(each, ast.ClassDef)
    }
    imports = {name: _imports(name, tree, name in _packages(folder)) for name, tree in modules.items()}
    package = folder.name
    facts: set[Fact] = set()
    for module, tree in modules.items():
        facts.add(Fact(module, "", "module"))
        foreign = {local for local, path in imports[module].items() if path.partition(".")[0] != package}
        facts |= {fact for fact in _names(module, tree) if fact.name not in foreign}
        if module in _packages(folder):
            facts |= {
                Fact(module, local, "value")
                for local, path in imports[module].items()
                if path.startswith(f"{package}.") and not local.startswith("_")
            }
        for each in _statements(tree.body):
            if isinstance(each, ast.ClassDef) and not each.name.startswith("_"):
                bases = _bases(f"{module}.{each.name}", classes, imports)
                facts |= set(_class(module, each, bases, package))
    named = {(fact.module, fact.name) for fact in facts if fact.kind in ("class", "function")}
    return {fact for fact in facts if fact.kind != "value" or (fact.module, fact.name) not in named}


def _packages(folder: Path) -> set[str]:
    return {".".join((folder.name, *path.parent.relative_to(folder).parts)) for path in folder.rglob("__init__.py")}


def _modules(folder: Path) -> Iterator[tuple[str, ast.Module]]:
    for path in sorted(folder.rglob("*.py")):
        parts = (folder.name, *path.relative_to(folder).with_suffix("").parts)
        if any(part.startswith(_TESTS) for part in parts):
            continue
        if parts[-1] == "__init__":
            parts = parts[:-1]
        try:
            tree = ast.parse(path.read_text(encoding="utf-8"))
        except SyntaxError:  # Python 2; its path counts
            tree = ast.Module([], [])
        yield ".".join(parts), tree


def _statements(body: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements of a module or class, also those in `if`, `try` and `with`."""
    for each in body:
        yield each
        for inner in ("body", "orelse", "finalbody"):
            if isinstance(each, (ast.If, ast.Try, ast.With)):
                yield from _statements(getattr(each, inner, ()))
        if isinstance(each, ast.Try):
            for handler in each.handlers:
                yield from _statements(handler.body)


def _imports(module: str, tree: ast.Module, is_package: bool) -> dict[str, str]:
    """The import path by local name."""
    found = {}
    for each in _statements(tree.body):
        if isinstance(each, ast.Import):
            for alias in each.names:
                local = alias.asname or alias.name.partition(".")[0]
                found[local] = alias.name if alias.asname else local
        elif isinstance(each, ast.ImportFrom):
            base = each.module or ""
            if each.level:
                parts = module.split(".")
                parts = parts[: len(parts) - each.level + (1 if is_package else 0)]
                base = ".".join(filter(None, (*parts, base)))
            for alias in each.names:
                if alias.name != "*":
                    found[alias.asname or alias.name] = f"{base}.{alias.name}"
    return found


def _names(module: str, tree: ast.Module) -> Iterator[Fact]:
    for each in _statements(tree.body):
        if isinstance(each, Function) and not each.name.startswith("_"):
            if not _is_overload(each):
                yield Fact(module, each.name, "function", plain(of_arguments(each.args)))
        elif isinstance(each, ast.ClassDef) and not each.name.startswith("_"):
            yield Fact(module, each.name, "class")
        else:
            for name in _assigned(each):
                if not name.startswith("_"):
                    yield Fact(module, name, "value")


def _assigned(statement: ast.stmt) -> Iterator[str]:
    targets = statement.targets if isinstance(statement, ast.Assign) else []
    if isinstance(statement, ast.AnnAssign):
        targets = [statement.target]
    for target in targets:
        for each in target.elts if isinstance(target, (ast.Tuple, ast.List)) else [target]:
            if isinstance(each, ast.Name):
                yield each.id


def _bases(
    path: str, classes: dict[str, tuple[str, ast.ClassDef]], imports: dict[str, dict[str, str]]
) -> dict[str, ast.ClassDef]:
    """The classes of the package from which a class derives, by import path, itself first."""
    found: dict[str, ast.ClassDef] = {}
    waiting = [path]
    while waiting:
        path = waiting.pop(0)
        for _ in range(5):  # an import from a package's face leads to the module of the class
            if path in classes or path.rpartition(".")[0] not in imports:
                break
            module, _, name = path.rpartition(".")
            path = imports[module].get(name, path)
        if path in classes and path not in found:
            module, tree = classes[path]
            found[path] = tree
            for base in tree.bases:
                first, _, rest = ast.unparse(base).partition("[")[0].partition(".")
                origin = imports[module].get(first, f"{module}.{first}")
                waiting.append(f"{origin}.{rest}" if rest else origin)
    return found


def _class(module: str, tree: ast.ClassDef, bases: dict[str, ast.ClassDef], package: str) -> Iterator[Fact]:
    methods = {name for base in bases.values() for name in _methods(base)}
    hooks = set(_calls_on_self(tree)) & methods
    own = _methods(tree)
    for base in list(bases)[1:]:
        yield Fact(module, tree.name, "base", base)
    for hook in hooks:
        if not hook.startswith("__"):
            yield Fact(module, f"{tree.name}.{hook}", "hook")
    for name, method in own.items():
        if name in _PROTOCOLS or (name.startswith("_") and not name.startswith("__") and name not in hooks):
            continue
        decorators = {ast.unparse(each).rpartition(".")[2] for each in method.decorator_list}
        if decorators & {"property", "cached_property", "setter", "getter"}:
            yield Fact(module, f"{tree.name}.{name}", "attribute")
        else:
            static = "staticmethod" in decorators
            yield Fact(
                module, f"{tree.name}.{name}", "method", plain(of_arguments(method.args), without_first=not static)
            )
    attributes = {name for each in tree.body for name in _assigned(each)}
    attributes |= set(_set_on_self(own["__init__"])) if "__init__" in own else set()
    for name in attributes - set(own):
        if not name.startswith("_"):
            yield Fact(module, f"{tree.name}.{name}", "attribute")


def _methods(tree: ast.ClassDef) -> dict[str, Function]:
    return {each.name: each for each in _statements(tree.body) if isinstance(each, Function) and not _is_overload(each)}


def _is_overload(function: Function) -> bool:
    return any(
        ast.unparse(each).endswith(("overload", ".register")) or ".register(" in ast.unparse(each)
        for each in function.decorator_list
    )


def _calls_on_self(tree: ast.AST) -> Iterator[str]:
    for each in ast.walk(tree):
        if isinstance(each, ast.Call) and isinstance(each.func, ast.Attribute) and _is_self(each.func.value):
            yield each.func.attr


def _set_on_self(tree: ast.AST) -> Iterator[str]:
    for each in ast.walk(tree):
        if isinstance(each, ast.Attribute) and isinstance(each.ctx, ast.Store) and _is_self(each.value):
            yield each.attr


def _is_self(tree: ast.expr) -> bool:
    return isinstance(tree, ast.Name) and tree.id == "self"
