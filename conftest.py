"""Runs the code blocks of the documentation as tests, in a folder of their own."""

import os
import shlex
import subprocess
import sys
import sysconfig
from pathlib import Path

from sybil import Example, Sybil
from sybil.parsers.markdown import CodeBlockParser, PythonCodeBlockParser


def run_atari_commands(example: Example) -> None:
    """Run the `atari` lines of a shell block; the scripts of set-up and test are what runs these tests."""
    for line in example.parsed.splitlines():
        words = shlex.split(line, comments=True)
        if words and words[0] == "atari":
            command = Path(sysconfig.get_path("scripts")) / "atari"
            subprocess.run([sys.executable, str(command), *words[1:]], check=True, timeout=300)


def enter_folder(namespace: dict[str, object], tmp_path: Path) -> None:
    """Run the blocks of a document in an empty folder."""
    namespace["folder"] = os.getcwd()
    os.chdir(tmp_path)


def leave_folder(namespace: dict[str, object]) -> None:
    """Go back to where the tests run."""
    os.chdir(str(namespace["folder"]))


pytest_collect_file = Sybil(
    parsers=[PythonCodeBlockParser(), CodeBlockParser("bash", run_atari_commands)],
    patterns=["README.md", "CONTRIBUTING.md", "docs/**/*.md", "atari/games/SCHEMA.md"],
    fixtures=["tmp_path"],
    setup=lambda namespace: enter_folder(namespace, namespace["tmp_path"]),
    teardown=leave_folder,
).pytest()
