"""Every script of `scripts` prints its help, and no folder of them is too large to look through."""

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from env_tools import needs_gymnasium_1, needs_new_ale_py

SCRIPTS = Path(__file__).parent.parent / "scripts"
SOURCED = {"setup.sh", "build_backend.py"}
"""Files of the scripts' folder that no user runs."""

SHELL = sorted(path for path in SCRIPTS.iterdir() if path.is_file() and not path.suffix)
PYTHON = sorted(
    path
    for path in (*SCRIPTS.glob("*.py"), *SCRIPTS.glob("bench/*.py"), *SCRIPTS.glob("generate/*.py"))
    if path.name not in SOURCED and 'if __name__ == "__main__":' in path.read_text(encoding="utf-8")
)


def name(path: Path) -> str:
    return path.relative_to(SCRIPTS).as_posix()


@pytest.mark.skipif(os.name == "nt", reason="the scripts need bash")
@pytest.mark.parametrize("script", SHELL, ids=name)
def test_a_shell_script_prints_its_help(script: Path) -> None:
    done = subprocess.run([str(script), "--help"], check=True, capture_output=True, text=True)
    assert f"usage: scripts/{script.name} [--help]" in done.stdout


@needs_gymnasium_1
@needs_new_ale_py
@pytest.mark.parametrize("script", PYTHON, ids=name)
def test_a_python_script_prints_its_help(script: Path) -> None:
    if script.name == "training.py" and not find_spec("torch"):
        pytest.skip("needs PyTorch")
    done = subprocess.run([sys.executable, str(script), "--help"], check=True, capture_output=True, text=True)
    assert done.stdout.startswith(f"usage: {script.name} [-h]")


@pytest.mark.parametrize(
    "folder", [SCRIPTS, *(path for path in SCRIPTS.iterdir() if path.is_dir())], ids=lambda f: f.name
)
def test_a_folder_has_at_most_twenty_entries(folder: Path) -> None:
    assert len([path for path in folder.iterdir() if path.name != "__pycache__"]) <= 20
