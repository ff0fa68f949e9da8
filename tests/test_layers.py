"""Which part of the package may import which: the table below, without cycles between modules.

A part is a module or a package directly in `atari`. Every import counts, those in functions and for type checkers too.
"""

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import atari
import atari.roms
import atari.wrappers

ALLOWED = {
    # The foundation imports no other part.
    "_emulator": "",
    "_gymnasium": "",
    "_interrupt": "",
    "_sources": "",
    "actions": "",
    "protocols": "",
    "_script": "",
    "validation": "",
    "notebook": "",
    "games": "actions notebook validation",
    "roms": "actions games validation",
    # The emulators, and the environments on them.
    "cores": "_emulator actions games roms validation",
    "rendering": "cores games validation",
    "env": "actions cores games notebook rendering roms validation",
    "restorable": "cores env",
    "wrappers": "_emulator actions cores env games protocols restorable validation",
    # Its views for JAX and PyTorch are of `integrations`, in modules that do not import `vector`.
    "vector": "_emulator _gymnasium actions cores games integrations multiplayer notebook protocols rendering roms validation "
    "wrappers",
    "registration": "actions cores env games validation vector wrappers",
    "algorithmic": "validation",
    "recording": "_gymnasium atari actions cores env games multiplayer notebook registration rendering restorable roms validation vector "
    "wrappers",
    "multiplayer": "_emulator actions cores env games recording rendering roms validation vector",
    "integrations": "_emulator _gymnasium _script actions classic cores env games lab learning recording registration validation vector "
    "wrappers",
    "sb3": "integrations",
    "learning": "_emulator _gymnasium _interrupt actions cores env games protocols recording registration rendering restorable "
    "validation vector wrappers",
    "lab": "_emulator _gymnasium actions cores env games recording registration rendering restorable roms validation vector "
    "wrappers",
    # The package itself exports the parts above, and `atari.__version__` to the parts below and to recordings.
    "atari": "actions algorithmic cores env games integrations registration roms vector wrappers",
    # Programs and old interfaces, which no part above imports; they may import `recording`.
    "play": "actions cores env games multiplayer recording registration rendering validation",
    "classic": "_script atari cores env games recording registration rendering validation wrappers",
    "cli": "_interrupt atari actions cores env games integrations lab learning multiplayer play recording registration rendering roms validation vector wrappers",
    "__main__": "cli",
}
"""By part, the parts that it may import."""


def sources() -> dict[str, Path]:
    """The file of every module by its name."""
    found = {}
    for package in (atari, atari.roms, atari.wrappers):
        folder = Path(str(package.__file__)).parent
        for file in folder.rglob("*.py"):
            parts = [package.__name__, *file.relative_to(folder).with_suffix("").parts]
            found[".".join(parts).removesuffix(".__init__")] = file
    return found


SOURCES = sources()


def imports(module: str) -> Iterator[str]:
    """The modules of this package that a module imports."""
    for node in ast.walk(ast.parse(SOURCES[module].read_text(encoding="utf-8"))):
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


GRAPH = {module: set(imports(module)) - {module} for module in SOURCES}


def part(module: str) -> str:
    return module.split(".")[1] if "." in module else module


@pytest.mark.parametrize("module", sorted(SOURCES))
def test_a_part_imports_only_what_it_may(module: str) -> None:
    own = part(module)
    assert own in ALLOWED, f"enter the new part {own!r} into the table"
    for imported in sorted(GRAPH[module]):
        assert part(imported) in {own, *ALLOWED[own].split()}, f"{own!r} may not import {imported}"


def test_no_module_imports_itself_through_others() -> None:
    try:
        TopologicalSorter(GRAPH).prepare()
    except CycleError as error:
        pytest.fail(f"a circle of imports, each by the next: {', '.join(error.args[1])}")
