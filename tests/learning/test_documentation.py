"""The code blocks of the documentation that need PyTorch."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from documents import blocks

from atari.cli import main

pytest.importorskip("torch")

EXAMPLES = Path(__file__).parents[2] / "examples"
BLOCKS = blocks("learn")
COMMANDS = blocks("learn", "bash")


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(EXAMPLES)  # a reader stands in the checkout
    exec(compile(BLOCKS[name], name, "exec"), {})


@pytest.mark.parametrize("name", COMMANDS)
def test_commands(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))  # for the programs that the user trusts
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    lines = [line.partition("#")[0].split() for line in COMMANDS[name].splitlines()]
    if any(program != "atari" for program, *_ in filter(None, lines)):
        subprocess.run(["bash", "-ec", COMMANDS[name]], check=True)
        return
    for _, *words in lines:
        assert main(words) == 0
