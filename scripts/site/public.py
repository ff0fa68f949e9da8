"""The public names of the package, read from its source without importing it: some modules need optional libraries."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

# Each of these is a folder of the repository.
PACKAGES = ("atari", "atari.wrappers", "atari.roms")

# Each of these has a page of the reference, and the names that are public beside those of `__all__`.
MODULES: dict[str, tuple[str, ...]] = {
    "atari": (),
    "atari.games": (
        "atari.games.actions.Action",
        "atari.games.catalog.games",
        "atari.games.game.Game",
        "atari.games.game.load_game",
    ),
    "atari.wrappers": (),
    "atari.multiplayer": (),
    "atari.cores": (),
    "atari.roms": (),
    "atari.testing": (),
    "atari.recording": (),
    "atari.play": (),
    "atari.lab": (),
    "atari.lab.interventions": (),
    "atari.lab.probes": (),
    "atari.learning": (),
    "atari.ale_py": (),
    "atari.sb3": (),
    "atari.integrations.envpool": (),
    "atari.integrations.jax": (),
    "atari.integrations.ray": (),
    "atari.classic": (),
    "atari.classic.algorithmic": (),
}


@dataclass(frozen=True)
class Definition:
    """The definition of a public name.

    Attributes:
        name: the name in the module of the reference, for example "Ram" of `atari.lab`.
        path: the path of the definition, for example "atari.lab.ram.Ram".
        docstring: the docstring of the class or function, or the string after a constant; "" if there is none.
        kind: "class", "function" or "constant".
        page: the module on whose page it is.
    """

    name: str
    path: str
    docstring: str
    kind: str
    page: str


def definitions(module: str) -> Iterator[Definition]:
    """The public names of a module that are classes, functions or constants of this package, in alphabetical order."""
    paths = {name: f"{module}.{name}" for name in exported(module)}
    paths |= {path.rpartition(".")[2]: path for path in MODULES[module]}
    for name, path in sorted(paths.items(), key=lambda item: item[0].lower()):
        found = resolve(*path.rpartition(".")[::2])
        if found:
            home, node = found
            yield Definition(
                name, f"{home}.{_name(node)}", _docstring(home, node), _kind(node), _page(home, module, name)
            )


def module_docstring(module: str) -> str:
    """The docstring of a module."""
    return ast.get_docstring(_tree(module)) or ""


def modules_with_public_names() -> Iterator[str]:
    """Every module of the package that has `__all__`."""
    for package in PACKAGES:
        folder = _source(package).parent
        for path in sorted(folder.rglob("*.py")):
            name = ".".join((package, *path.relative_to(folder).with_suffix("").parts)).removesuffix(".__init__")
            if any(_name(node) == "__all__" for node in ast.parse(path.read_text(encoding="utf-8")).body):
                yield name


def resolve(module: str, name: str) -> tuple[str, ast.stmt] | None:
    """The module and the statement that define a name, after imports; None for modules and other packages' names."""
    imported = None
    for node in ast.walk(_tree(module)):
        if isinstance(node, ast.ImportFrom) and any((part.asname or part.name) == name for part in node.names):
            imported = node
    for node in _tree(module).body:
        if _name(node) == name and not isinstance(node, ast.ImportFrom):
            return module, node
    if imported is None or imported.module == module or not (imported.module or "").startswith("atari"):
        return None  # a module of this package, or a name of another package
    original = next(part.name for part in imported.names if (part.asname or part.name) == name)
    return resolve(str(imported.module), original)


def _page(home: str, module: str, name: str) -> str:
    """The page of a definition: the innermost module of the reference around it that exports it, or `module`."""
    around = [page for page in MODULES if home == page or home.startswith(f"{page}.")]
    if module in around:
        return max((page for page in around if page.startswith(f"{module}.")), key=len, default=module)
    own = [page for page in around if name in exported(page) and (found := resolve(page, name)) and found[0] == home]
    return max(own, key=len, default=module)


def exported(module: str) -> list[str]:
    """The `__all__` of a module."""
    for node in _tree(module).body:
        if isinstance(node, ast.Assign) and _name(node) == "__all__":
            return list(ast.literal_eval(node.value))
    return []


def _name(node: ast.AST) -> str:
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return node.name
    if isinstance(node, ast.AnnAssign) and node.value is None:
        return ""  # a module that is made when it is imported
    target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
    return target.id if isinstance(target, ast.Name) else ""


def _kind(node: ast.AST) -> str:
    return {ast.ClassDef: "class", ast.FunctionDef: "function"}.get(type(node), "constant")


def _docstring(module: str, node: ast.stmt) -> str:
    if isinstance(node, ast.ClassDef | ast.FunctionDef):
        return ast.get_docstring(node) or ""
    body = _tree(module).body
    after = body[body.index(node) + 1 : body.index(node) + 2]
    for following in after:
        if isinstance(following, ast.Expr) and isinstance(following.value, ast.Constant):
            return str(following.value.value)
    return ""


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(_source(module).read_text(encoding="utf-8"))


def _source(module: str) -> Path:
    """The file of a module. `find_spec` would import the packages around it, and that of Ray needs Ray."""
    package = next(name for name in reversed(PACKAGES) if f"{module}.".startswith(f"{name}."))
    spec = find_spec(package)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"there is no package {package}")
    path = Path(spec.origin).parent.joinpath(*module.removeprefix(package).split(".")[1:])
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
