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
    new, old = (ast.dump(ast.parse(path.read_text()), indent=1) for path in (tmp_path / "new.pyi", stub))
    assert new == old, "run: python -m nanobind.stubgen -m atari._emulator -o atari/_emulator.pyi"
