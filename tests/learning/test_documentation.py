"""The code blocks of the documentation that need PyTorch."""

import itertools
import os
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from documents import blocks

from atari.cli import main
from atari.recording import Replay

pytest.importorskip("torch")

from small_trainings import sweep_in_this_process

EXAMPLES = Path(__file__).parents[2] / "examples"
BLOCKS = blocks("learn")
COMMANDS = blocks("learn", "bash")


def program_of(line: str) -> str:
    """The program of a line that needs no process of its own, or nothing."""
    word = line.partition(" ")[0]
    return word if word in ("atari", "python") else ""


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(EXAMPLES)  # a reader stands in the checkout
    exec(compile(BLOCKS[name], name, "exec"), {})


@pytest.mark.parametrize("name", COMMANDS)
def test_commands(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands of `atari` and scripts run in this process, which has imported PyTorch; other lines run in bash."""
    monkeypatch.chdir(tmp_path)
    Path("examples").symlink_to(EXAMPLES)
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))  # for the programs that the user trusts
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    sweep_in_this_process(monkeypatch)
    render = Replay.render  # of a second: a policy that has learned nothing plays long games
    monkeypatch.setattr(Replay, "render", lambda *of, **options: render(*of, **{"stop": 60, **options}))
    lines = COMMANDS[name].replace("\\\n", "").splitlines()
    for program, part in itertools.groupby(lines, program_of):
        if not program:
            subprocess.run(["bash", "-ec", "\n".join(part)], check=True)
            continue
        for _, *words in (shlex.split(line, comments=True) for line in part):
            if program == "atari":
                assert main(words) == 0
            else:
                monkeypatch.setattr(sys, "argv", words)
                runpy.run_path(words[0], run_name="__main__")
