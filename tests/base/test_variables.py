"""The environment variables of the package: one table, which the code, the documentation and the errors agree with."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from package_modules import SOURCES

from atari.base.variables import VARIABLES

ROOT = Path(__file__).parents[2]


def test_the_package_reads_no_other_variable() -> None:
    found = set()
    for path in (*SOURCES.values(), *(ROOT / "atari/emulator").rglob("*.[ch]pp")):
        read = re.findall(r'(?:getenv\(|environ\b.*?)"(ATARI_\w+)"', path.read_text(encoding="utf-8"))
        found |= set(read)
        assert path.suffix == ".cpp" or not read, f"{path} reads {read} past atari/base/variables.py"
    assert found == {"ATARI_SIMD", "ATARI_JIT"}
    assert found < {*VARIABLES}


def test_the_documentation_has_them_all() -> None:
    page = (ROOT / "docs/command-line.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(ATARI_\w+)` \| (.*?) \| .+ \|$", page, re.M)
    assert rows == [(name, variable.values) for name, variable in VARIABLES.items()]


CHECKED = [name for name in VARIABLES if name != "ATARI_ROMS"]


def run(name: str, *words: str) -> "subprocess.CompletedProcess[str]":
    """Run Python with a wrong value of a variable."""
    environment = {**os.environ, name: "?"}
    return subprocess.run([sys.executable, *words], env=environment, capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize(
    ("name", "program"), zip(CHECKED, ("atari info", "atari.classic", "atari.cli.sweep list"), strict=True)
)
def test_a_wrong_value_ends_a_program_with_one_sentence(name: str, program: str) -> None:
    done = run(name, "-m", *program.split())
    assert (done.returncode, done.stdout) == (1, "")
    assert re.fullmatch(rf"atari: error: the environment variable {name} .*\'\?\'.*\n", done.stderr)


@pytest.mark.parametrize("name", CHECKED)
def test_a_wrong_value_is_a_value_error_for_a_users_program(name: str) -> None:
    done = run(name, "-c", "try: import atari\nexcept ValueError as error: print(error)")
    assert (done.returncode, done.stderr) == (0, "")
    assert f"the environment variable {name}" in done.stdout
