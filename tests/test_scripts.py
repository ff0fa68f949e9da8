"""Every script of `scripts` prints its help, no folder of them is too large to look through, and a build that fails."""

import importlib
import os
import re
import runpy
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest
import site_modules
from env_tools import needs_gymnasium_1, needs_new_ale_py

from atari.recording import Replay

SCRIPTS = Path(__file__).parent.parent / "scripts"
quickstart = site_modules.load("quickstart", "")
SHELL = sorted(path for path in (*SCRIPTS.iterdir(), *SCRIPTS.glob("release/*")) if path.is_file() and not path.suffix)
PYTHON = sorted(
    path
    for path in (
        *SCRIPTS.glob("*.py"),
        *SCRIPTS.glob("bench/*.py"),
        *SCRIPTS.glob("generate/*.py"),
        *SCRIPTS.glob("release/*.py"),
    )
    if 'if __name__ == "__main__":' in path.read_text(encoding="utf-8")
)


def name(path: Path) -> str:
    return path.relative_to(SCRIPTS).as_posix()


@pytest.mark.skipif(os.name == "nt", reason="the scripts need bash")
@pytest.mark.parametrize("script", SHELL, ids=name)
def test_a_shell_script_prints_its_help(script: Path) -> None:
    done = subprocess.run([str(script), "--help"], check=True, capture_output=True, text=True)
    assert f"usage: scripts/{name(script)} [--help]" in done.stdout


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


@pytest.mark.parametrize(
    ("system", "advice"),
    [("Linux", "apt install g++"), ("Darwin", "xcode-select --install"), ("Windows", "Clang tools")],
)
def test_quickstart_says_how_to_get_a_compiler(
    system: str, advice: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(quickstart.platform, "system", lambda: system)
    monkeypatch.setattr(quickstart, "WINDOWS", system == "Windows")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("PROGRAMFILES(X86)", str(tmp_path))
    monkeypatch.delenv("CXX", raising=False)
    with pytest.raises(SystemExit, match=rf"A C\+\+20 compiler is missing, and .*; .*{re.escape(advice)}"):
        quickstart.check_compiler(", and there is no wheel")


@pytest.mark.skipif(os.name == "nt", reason="the installer's program is a script of the shell here")
@pytest.mark.parametrize(("printed", "variables"), [("C:/VS", {"CMAKE_GENERATOR_TOOLSET": "ClangCL"}), ("", None)])
def test_quickstart_finds_clang_of_visual_studio(
    printed: str, variables: dict[str, str] | None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    finder = tmp_path / "Microsoft Visual Studio" / "Installer" / "vswhere.exe"
    finder.parent.mkdir(parents=True)
    finder.write_text(f"#!/bin/sh\ncase $* in *Llvm.Clang*) echo '{printed}' ;; esac\n", encoding="utf-8")
    finder.chmod(0o755)
    monkeypatch.setenv("PROGRAMFILES(X86)", str(tmp_path))
    monkeypatch.setattr(quickstart, "WINDOWS", True)
    assert quickstart.find_compiler() == variables


def write_wheel(folder: Path, tag: str, version: str, *requirements: str) -> Path:
    """A wheel of this package's name without contents."""
    folder.mkdir(exist_ok=True)
    wheel = folder / f"atari_envs-{version}-{tag}.whl"
    metadata = ("Metadata-Version: 2.1", "Name: atari-envs", f"Version: {version}", *requirements)
    with zipfile.ZipFile(wheel, "w") as opened:
        for file, text in (
            ("METADATA", "\n".join(metadata)),
            ("WHEEL", f"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: {tag}"),
            ("RECORD", ""),
        ):
            opened.writestr(f"atari_envs-{version}.dist-info/{file}", text + "\n")
    return wheel


@pytest.mark.parametrize("fits", [True, False])
def test_quickstart_takes_a_fitting_wheel(fits: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(quickstart, "ROOT", tmp_path)
    monkeypatch.setattr(quickstart, "version", lambda: "0.2.0")
    write_wheel(tmp_path / "dist", "py3-none-any", "0.1.0")
    write_wheel(tmp_path / "dist", "cp27-cp27m-win32", "0.2.0")
    if fits:
        write_wheel(tmp_path / "wheelhouse", "py3-none-any", "0.2.0")
    folders = [str(tmp_path / name) for name in ("dist", "wheelhouse", "missing")]
    found = quickstart.fitting_wheel(sys.executable, folders)
    assert (found.name if found else None) == ("atari_envs-0.2.0-py3-none-any.whl" if fits else None)


def test_a_broken_virtual_environment_does_not_stay(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def create(folder: Path, **_: object) -> None:
        (folder / "bin").mkdir(parents=True)
        raise OSError("no ensurepip")

    monkeypatch.setattr(quickstart.environments, "create", create)
    with pytest.raises(SystemExit, match=r"cannot make virtual environments \(no ensurepip\); install"):
        quickstart.make_venv(tmp_path / "venv")
    assert not (tmp_path / "venv").exists()


def test_the_oldest_dependencies_of_a_wheel(tmp_path: Path) -> None:
    installs = site_modules.load("installs", "release")
    requirements = ("numpy>=1.24", "ale-py>=0.8.1", 'tomli>=2; python_version < "3.11"', 'av>=14; extra == "video"')
    wheel = write_wheel(tmp_path, "py3-none-any", "0.2.0", *(f"Requires-Dist: {each}" for each in requirements))
    assert installs.oldest_dependencies(wheel) == "numpy==1.24\nale-py==0.8.1\ntomli==2\n"


def test_the_members_in_which_two_builds_differ(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    reproducible = site_modules.load("reproducible", "release")
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "equal.tar.gz").write_bytes(b"the same")
        with zipfile.ZipFile(tmp_path / folder / "a.whl", "w") as opened:
            opened.writestr(zipfile.ZipInfo("same.py"), "")
            opened.writestr(zipfile.ZipInfo("module.so"), str(tmp_path / folder))
    assert not reproducible.compare(tmp_path / "first", tmp_path / "second")
    printed = capsys.readouterr().out
    assert "a.whl: module.so: " in printed
    assert "same.py" not in printed
    assert printed.endswith("The builds differ.\n")
    shutil.copy(tmp_path / "first" / "a.whl", tmp_path / "second")
    assert reproducible.compare(tmp_path / "first", tmp_path / "second")


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
    for file in ("pyproject.toml", "CMakeLists.txt", "README.md", "LICENSE", "LICENSE-THIRD-PARTY"):
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
    assert [*quickstart.progress(iter(lines))] == [
        lines[0],
        "  [12/83] Building atari/emulator/observations/observation_stack.cpp",
        "  [81/83] Building atari/emulator/python/binding.cpp",
        "  Linking, with optimisation over all files: about a minute without a line",
        "  [82/83] Linking CXX shared module _emulator",
        "  [83/83] Generating _emulator.pyi",
    ]
