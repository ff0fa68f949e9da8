"""Runs the code blocks of the documentation as tests, in an empty folder, and removes the IDs that they register."""

import os
import shlex
import subprocess
import sys
import sysconfig
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
from sybil import Example, Sybil
from sybil.parsers.markdown import CodeBlockParser, PythonCodeBlockParser

import atari  # noqa: F401 - registers its IDs before any document does
from atari.cli import main

_DATA = TemporaryDirectory()
# ROM files that tests import and programs that they trust are not the user's.
os.environ["XDG_DATA_HOME"] = _DATA.name

IN_PROCESS = ("info", "record", "replay")
"""Commands that need no process of their own, which takes a second to import the package."""


def run_atari_commands(example: Example) -> None:
    """Run the lines of a shell block that run this package; other lines, as ./scripts/test, would run these tests."""
    for line in example.parsed.splitlines():
        words = shlex.split(line, comments=True)
        if words and words[0] == "atari":
            if words[1] in IN_PROCESS:
                assert main(words[1:]) == 0, line
                continue
            command = Path(sysconfig.get_path("scripts")) / "atari"
            subprocess.run([sys.executable, str(command), *words[1:]], check=True, timeout=300)
        elif words[:2] == ["python", "-m"] and words[2] in ("atari.classic", "atari.integrations.envpool"):
            subprocess.run([sys.executable, *words[1:]], check=True, timeout=300)


def enter_folder(namespace: dict[str, Any]) -> None:
    """Run the blocks of a document in an empty folder."""
    namespace["repository"] = Path(__file__).parent
    namespace["came_from"] = Path.cwd()
    namespace["folder"] = TemporaryDirectory()
    os.chdir(namespace["folder"].name)
    namespace["known_ids"] = set(gymnasium.registry)


def leave_folder(namespace: dict[str, Any]) -> None:
    """Restore the working folder and Gymnasium's registry."""
    for env_id in set(gymnasium.registry) - namespace["known_ids"]:
        del gymnasium.registry[env_id]
    os.chdir(namespace["came_from"])
    namespace["folder"].cleanup()


pytest_collect_file = Sybil(
    parsers=[PythonCodeBlockParser(), CodeBlockParser("bash", run_atari_commands)],
    patterns=["README.md", "CONTRIBUTING.md", "docs/*.md", "docs/recipes/*.md", "atari/games/SCHEMA.md"],
    setup=enter_folder,
    teardown=leave_folder,
).pytest()
