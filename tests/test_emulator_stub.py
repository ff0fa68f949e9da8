"""The stub of the extension module is up to date with nanobind's output, so that reviewers see every change of it."""

import ast
import subprocess
import sys
from pathlib import Path

import atari


def test_the_stub_is_up_to_date(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "nanobind.stubgen", "-q", "-m", "atari._emulator", "-o", str(tmp_path / "new.pyi")]
    subprocess.run(command, check=True, cwd=tmp_path)
    stub = Path(atari.__file__).with_name("_emulator.pyi")
    new, old = (ast.dump(_parse(path), indent=1) for path in (tmp_path / "new.pyi", stub))
    assert new == old, "run: python -m nanobind.stubgen -m atari._emulator -o atari/_emulator.pyi"


def _parse(path: Path) -> ast.Module:
    """A stub without `__buffer__`, a method that Python shows since 3.12."""
    tree = ast.parse(path.read_text())
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            node.body = [item for item in node.body if getattr(item, "name", "") != "__buffer__"]
    return tree
