"""The order of the parts of the package: each imports only parts that stand before it in the list below.

A part is a module or a package directly in `atari`. Every import counts, those in functions and for type checkers too,
but for the lazy attributes of `atari`. No module imports itself through others.
"""

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter

import pytest
from package_modules import SOURCES

ORDER = """
    base
    games roms _emulator cores
    task env wrappers
    vector multiplayer registry
    atari
    ale_py policy testing
    web recording lab learning
    classic integrations sb3
    play cli __main__
""".split()
"""The parts, from the bottom to the top.

- `classic` imports the public API and `base` alone, which a test below keeps; it stands before `integrations`, because EnvPool's
  runner gives old scripts its `gym`.
- `atari` is the module `atari/__init__.py`; the parts after it are its lazy attributes, or no attributes.
"""

LAZY = {
    *("atari.classic", "atari.integrations", "atari.lab", "atari.learning", "atari.recording", "atari.testing"),
    "atari.integrations.arrays",  # the home of `to_jax` and `to_torch`
}
"""The modules of later parts that `atari` has as lazy attributes."""


def imports(tree: ast.AST, module: str) -> Iterator[str]:
    """The modules of this package that a part of a module's tree imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{module}: write relative imports in full"
            names = []
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                names.append(name if name in SOURCES or name == "atari._emulator" else str(node.module))
        else:
            continue
        yield from (name for name in names if name.split(".")[0] == "atari")


@cache
def tree_of(module: str) -> ast.Module:
    return ast.parse(SOURCES[module].read_text(encoding="utf-8"))


@cache
def imported_by(module: str) -> set[str]:
    """The modules that a module imports, without the lazy attributes of `atari`."""
    return {*imports(tree_of(module), module)} - {module, *(LAZY if module == "atari" else ())}


def part(module: str) -> str:
    return module.split(".")[1] if "." in module else module


def against_the_order(module: str, imported: set[str]) -> list[str]:
    """The imports of a module that the order does not allow."""
    own = part(module)
    assert own in ORDER, f"enter the new part {own!r} into the list"
    below = ORDER[: ORDER.index(own) + 1]
    return sorted(name for name in imported if part(name) not in below)


def test_a_part_imports_only_parts_before_it() -> None:
    assert not {module: found for module in SOURCES if (found := against_the_order(module, imported_by(module)))}


def test_every_part_of_the_list_exists() -> None:
    assert sorted(ORDER) == sorted({part(module) for module in SOURCES} | {"_emulator"})


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("atari.task.rules", "from atari.vector import AtariVectorEnv"),
        ("atari.recording.episodes", "import atari.lab"),
        ("atari.web.film", "from atari.recording import Replay"),
        ("atari.cores.native", "def late():\n    from atari.task import Task"),
        ("atari.games.game", "from atari import _emulator"),
        ("atari.base.durable", "from atari.games import actions"),
    ],
)
def test_an_import_against_the_order_is_found(module: str, line: str) -> None:
    assert against_the_order(module, {*imports(ast.parse(line), module)})


def circle(module: str = "atari", line: str = "") -> list[str]:
    """A circle of imports, each module imported by the next, with a line added to a module; [] if there is none."""
    graph = {name: imported_by(name) for name in SOURCES}
    try:
        TopologicalSorter({**graph, module: graph[module] | {*imports(ast.parse(line), module)}}).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_module_imports_itself_through_others() -> None:
    assert not circle()
    assert circle("atari.task.data", "def late():\n    from atari.task import Task")
    assert circle("atari.learning.run_folder", "if TYPE_CHECKING:\n    from atari.learning.training import Training")


def test_lazy_attributes_are_imported_when_they_are_used() -> None:
    later = (ast.FunctionDef, ast.If)  # `__getattr__`, or `if TYPE_CHECKING`
    at_once = {name for node in tree_of("atari").body if not isinstance(node, later) for name in imports(node, "atari")}
    assert not LAZY & at_once
    assert {*imports(tree_of("atari"), "atari")} >= LAZY, "take what is not imported any more out of LAZY"


def _private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def nodes(of_part: str | None = None) -> Iterator[tuple[str, ast.AST]]:
    """The nodes of the modules of a part, or of all, each with its module."""
    for module in SOURCES:
        if of_part in (None, part(module)):
            yield from ((module, node) for node in ast.walk(tree_of(module)))


@cache
def own_names(of_part: str) -> set[str]:
    """The names that the modules of a part define: functions, classes, variables, and attributes that they set."""
    found = set()
    for _, node in nodes(of_part):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            found.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            found.add(node.attr)
    return found


OF_OTHERS = {
    "_SubParsersAction",  # argparse names no public type
    "_asdict",  # a named tuple's, public in spite of its name
    "_exit",  # of os, public in spite of its name
    "_elapsed_steps",  # of Gymnasium's TimeLimit, which has no other access to its state
    "_getframe",  # of sys
    "_has_reset",  # of Gymnasium's OrderEnforcing
    "_replace",  # a named tuple's
    "_saved_kwargs",  # of Gymnasium's RecordConstructorArgs
}
"""Private names of other libraries."""


def test_a_part_uses_no_private_name_of_another() -> None:
    for module, node in nodes():
        own = part(module)
        if isinstance(node, ast.Attribute) and _private(node.attr) and node.attr not in OF_OTHERS:
            by_itself = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            assert by_itself or node.attr in own_names(own), f"{module}:{node.lineno}: {ast.unparse(node)}"
        if isinstance(node, ast.ImportFrom) and node.module and part(node.module) != own and "." in node.module:
            names = [*node.module.split(".")[2:], *(alias.name for alias in node.names)]
            assert not any(map(_private, names)), f"{module}:{node.lineno}: {ast.unparse(node)}"


def _is_public(module: str, name: str) -> bool:
    homes = ("atari", "atari.recording", "atari.roms", "atari.wrappers")
    return (module in homes or part(module) == "base") and not _private(name)


def test_classic_imports_the_public_api_alone() -> None:
    for _, node in nodes("classic"):
        if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] == "atari":
            if part(str(node.module)) != "classic":
                assert all(_is_public(str(node.module), alias.name) for alias in node.names), ast.unparse(node)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                assert not alias.name.startswith("atari.") or part(alias.name) == "classic", ast.unparse(node)
