"""The code blocks of the documentation that need PyTorch."""

import shlex
from pathlib import Path

import pytest
from documents import blocks

from atari.cli import main

pytest.importorskip("torch")

BLOCKS = blocks("learn")
COMMANDS = blocks("learn", "bash")


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(BLOCKS[name], name, "exec"), {})


@pytest.mark.parametrize("name", COMMANDS)
def test_commands(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for line in COMMANDS[name].splitlines():
        program, *words = shlex.split(line, comments=True)
        assert program == "atari"
        assert main(words) == 0


def test_there_are_some() -> None:
    assert len(BLOCKS) >= 2
    assert len(COMMANDS) >= 1
