"""Every script of `scripts` prints its help, no folder of them is too large to look through, and a build that fails."""

import importlib
import os
import re
import runpy
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from env_tools import needs_gymnasium_1, needs_new_ale_py

from atari.recording import Replay

SCRIPTS = Path(__file__).parent.parent / "scripts"
SHELL = sorted(path for path in SCRIPTS.iterdir() if path.is_file() and not path.suffix)
PYTHON = sorted(
    path
    for path in (*SCRIPTS.glob("*.py"), *SCRIPTS.glob("bench/*.py"), *SCRIPTS.glob("generate/*.py"))
    if 'if __name__ == "__main__":' in path.read_text(encoding="utf-8")
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
def test_a_python_script_prints_its_help(
    script: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    if script.name == "training.py" and not find_spec("torch"):
        pytest.skip("needs PyTorch")
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "argv", [str(script), "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(script), run_name="__main__")
    assert not ended.value.code
    assert capsys.readouterr().out.startswith(f"usage: {script.name} [-h]")


@needs_gymnasium_1
@needs_new_ale_py
def test_the_speeds_of_quickstart(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "path", [str(SCRIPTS / "bench"), *sys.path])
    quick = importlib.import_module("quick")
    monkeypatch.setattr(quick, "SECONDS", 0.02)
    monkeypatch.setattr(sys, "argv", ["quick.py", "qbert"])
    quick.main()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["frames", "a", "second", "of", "qbert", "atari-envs", "ale-py"]
    for line in lines[1:]:
        ours, theirs, ratio = (float(text.replace(",", "")) for text in re.findall(r"[\d,]+\.?\d*", line))
        assert ratio == pytest.approx(ours / theirs, rel=0.1)


def test_the_game_of_quickstart() -> None:
    replay = Replay.load(SCRIPTS.parent / "examples" / "qbert.a26r")
    assert replay.verify()
    assert [episode.score for episode in replay.episodes] == [7950]


@pytest.mark.parametrize(
    "folder",
    sorted([SCRIPTS, *(path for path in SCRIPTS.iterdir() if path.is_dir() and path.name != "__pycache__")]),
    ids=lambda f: f.name,
)
def test_a_folder_has_at_most_twenty_entries(folder: Path) -> None:
    assert len([path for path in folder.iterdir() if path.name != "__pycache__"]) <= 20


@pytest.mark.skipif(not find_spec("scikit_build_core"), reason="needs scikit-build-core")
def test_a_build_that_fails_says_what_to_install(tmp_path: Path) -> None:
    for file in ("pyproject.toml", "CMakeLists.txt", "README.md", "LICENSE"):
        shutil.copy(SCRIPTS.parent / file, tmp_path)
    build = [sys.executable, "-c", "from scikit_build_core.build import build_wheel; build_wheel('.')"]
    environment = {**os.environ, "CXX": str(tmp_path / "no-compiler")}
    done = subprocess.run(build, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert done.returncode == 1
    assert "or set CXX." in done.stdout.splitlines()[-1]
    assert "takes a C++20 compiler" in done.stdout


def test_the_progress_of_a_build_fits_in_a_terminal() -> None:
    lines = (
        "Installing build dependencies: started",
        "  [12/83] Building CXX object CMakeFiles/emulator.dir/atari/emulator/observations/observation_stack.cpp.o",
        "  [81/83] Building CXX object CMakeFiles/_emulator.dir/atari/emulator/python/binding.cpp.o",
        "  [82/83] Linking CXX shared module _emulator.cpython-311-x86_64-linux-gnu.so",
        "  [83/83] Generating _emulator.pyi",
    )
    command = f"set -euo pipefail; source {SCRIPTS / 'setup.sh'}; show_progress"
    done = subprocess.run(
        ["bash", "-c", command], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines() == [
        lines[0],
        "  [12/83] Building atari/emulator/observations/observation_stack.cpp",
        "  [81/83] Building atari/emulator/python/binding.cpp",
        "  Linking, with optimisation over all files: about a minute without a line",
        "  [82/83] Linking CXX shared module _emulator",
        "  [83/83] Generating _emulator.pyi",
    ]
