"""The commands that error messages name: they install what is missing for the Python that runs."""

import os
import subprocess
import sys
from importlib.metadata import metadata, requires
from pathlib import Path

import gymnasium
import pytest

from atari.base import extras
from atari.base.extras import import_extra, install_extra, pip_install

EXTRAS = [extra for extra in metadata("atari-envs").get_all("Provides-Extra") or [] if extra != "dev"]


def test_the_command_is_of_this_python() -> None:
    assert pip_install("torch") == f"{sys.executable} -m pip install torch"
    assert install_extra("learn") == (
        f"{sys.executable} -m pip install 'torch>=2.2' 'tensorboard>=2.14' 'matplotlib>=3.7'"
    )


@pytest.mark.parametrize("extra", EXTRAS)
def test_every_extra_names_its_packages(extra: str) -> None:
    lines = [line for line in requires("atari-envs") or [] if f'extra == "{extra}"' in line.replace("'", '"')]
    assert lines
    for line in lines:
        assert line.partition(";")[0].strip() in install_extra(extra)


def test_a_path_with_a_space_is_quoted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/my env/bin/python")
    assert pip_install("torch") == "'/my env/bin/python' -m pip install torch"


def test_pip_understands_the_command() -> None:
    command = f"{install_extra('play')} --dry-run --no-index --no-deps --ignore-installed"
    result = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert "No matching distribution found for pygame-ce>=2.4" in result.stderr


def test_a_missing_module_is_an_error_with_the_command() -> None:
    with pytest.raises(gymnasium.error.DependencyNotInstalled, match="it needs x: pip"):
        import_extra("no_such_module_at_all", "it needs x: pip")


def test_a_command_says_what_it_loads(tmp_path: Path) -> None:
    (tmp_path / "torch.py").write_text("raise ImportError('as if it were not installed')")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "config.json").write_text("{}")
    command = [sys.executable, "-m", "atari", "watch", "run"]
    path = {**os.environ, "PYTHONPATH": str(tmp_path)}
    result = subprocess.run(command, cwd=tmp_path, env=path, capture_output=True, text=True, check=False)
    first, second = result.stderr.splitlines()
    assert first == "atari: loading PyTorch, which takes some seconds"
    assert second.startswith("atari: error: run, a run folder, needs torch: ")
    script = "from atari.learning import load_policy\ntry: load_policy('run')\nexcept Exception as e: print(e)"
    result = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=path, capture_output=True, text=True, check=False
    )
    assert (result.stderr, "needs torch" in result.stdout) == ("", True)


def test_a_package_that_is_missing_is_not_announced(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extras, "PROGRAM", True)
    monkeypatch.setattr(extras, "_SLOW", {"no_such_package": "No such package", "colorsys": "colours"})
    monkeypatch.delitem(sys.modules, "colorsys", raising=False)
    with pytest.raises(gymnasium.error.DependencyNotInstalled):
        extras.import_extra("no_such_package", "it is needed")
    assert capfd.readouterr().err == ""
    extras.import_extra("colorsys", "it is needed")
    assert capfd.readouterr().err == "atari: loading colours, which takes some seconds\n"
