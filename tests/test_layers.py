"""Which part of the package may import which: the table below, without cycles between modules.

A part is a module or a package directly in `atari`. Every import counts, those in functions and for type checkers too,
but for the few of `UPWARD`.
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
    "_renamed": "",
    "protocols": "_renamed",
    "_sources": "",
    "actions": "",
    "_script": "",
    "validation": "",
    "notebook": "",
    "games": "actions notebook validation",
    "roms": "actions games validation",
    # The emulators, and the environments on them.
    "cores": "_emulator actions games roms validation",
    "rendering": "cores games validation",
    # What is played, and the environments that play it.
    "env_ids": "games",
    "task": "actions cores env_ids games validation",
    "env_state": "cores games task",
    "env": "actions cores env_state games notebook rendering task validation",
    "restorable": "cores env task",
    "wrappers": "_emulator _renamed cores env games restorable task validation vector",
    # Its views for JAX and PyTorch are of `integrations`, in modules that do not import `vector`.
    "vector": "_emulator _gymnasium actions cores games integrations multiplayer notebook rendering roms task validation",
    "policy": "task",
    "policy_needs": "games task validation vector",
    "observations": "_emulator cores task vector",
    "testing": "_emulator _gymnasium cores env games policy policy_needs task vector",
    "making": "env env_ids task validation vector wrappers",
    "registration": "cores env_ids games making roms task",
    "algorithmic": "validation",
    "recording": "_gymnasium atari actions cores env env_ids games making multiplayer notebook rendering restorable roms task "
    "validation vector wrappers",
    "multiplayer": "_emulator _renamed actions cores env games observations recording rendering roms task validation vector",
    "integrations": "_emulator _gymnasium _script classic cores env_ids games lab learning recording task validation vector wrappers policy policy_needs",
    "sb3": "integrations",
    "learning": "_emulator _gymnasium _interrupt actions cores env env_ids games making observations recording registration rendering "
    "restorable task validation vector wrappers policy policy_needs",
    "lab": "_emulator _gymnasium actions cores env games recording registration rendering restorable roms task validation vector "
    "wrappers",
    # The package itself exports the parts above, and `atari.__version__` to the parts below and to recordings.
    "atari": "_renamed actions algorithmic cores env games integrations making registration roms task vector wrappers",
    # Programs and old interfaces, which no part above imports; they may import `recording`.
    "play": "actions cores env games learning multiplayer observations recording registration rendering task validation policy policy_needs",
    "classic": "_script atari cores env env_ids games recording registration rendering validation wrappers",
    "cli": "_interrupt atari actions cores env env_ids games integrations lab learning making multiplayer observations play "
    "recording registration rendering roms task validation vector wrappers policy policy_needs",
    "__main__": "cli",
}
"""By part, the parts that it may import."""

UPWARD = {
    # `Task.of`, `to_json`, `from_json` and `str` need modules that make tasks themselves.
    "atari.task.task": "atari.task.resolution atari.task.storage atari.task.description atari.making atari.vector",
    # `TorchEnvs` makes the vector of a game; `AtariVectorEnv.torch` makes a `TorchEnvs`.
    "atari.integrations.torch": "atari.vector.env",
}
"""By module, what methods of its classes import when they are called: modules that import this one. `Task.make` and
`Task.make_vec` are the others. These imports are in functions or for type checkers only."""


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


TREES = {module: ast.parse(file.read_text(encoding="utf-8")) for module, file in SOURCES.items()}
GRAPH = {module: {*imports(tree, module)} - {module, *UPWARD.get(module, "").split()} for module, tree in TREES.items()}


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


@pytest.mark.parametrize("module", UPWARD)
def test_imports_upwards_are_made_when_a_function_is_called(module: str) -> None:
    later = (ast.FunctionDef, ast.ClassDef, ast.If)  # a method, or `if TYPE_CHECKING`
    at_once = {name for node in TREES[module].body if not isinstance(node, later) for name in imports(node, module)}
    upward = {*UPWARD[module].split()}
    assert not upward & at_once
    assert upward <= {*imports(TREES[module], module)}, "take what is not imported any more out of the table"
