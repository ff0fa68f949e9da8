"""`atari info` without a game: what works here, and the commands that install the rest."""

import re
import sys
from importlib.metadata import metadata, requires
from pathlib import Path

import pytest
from cli_tools import Capture, read, read_json
from env_tools import OLD_ALE_PY

import atari
from atari import roms
from atari.cli import installation
from atari.cli.installation import USES
from atari.web import shelf

ALE = "missing: pip install --upgrade ale-py" if OLD_ALE_PY else None
"""The error of ale-py's core."""


def blocked(monkeypatch: pytest.MonkeyPatch, *modules: str) -> None:
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)


def row(out: str, name: str) -> str:
    return next(line.strip() for line in out.splitlines() if line.strip().startswith(name)).removeprefix(name).strip()


def test_the_uses_are_the_extras_of_the_package() -> None:
    declared: dict[str, set[str]] = {name: set() for name in metadata("atari-envs").get_all("Provides-Extra") or []}
    for line in requires("atari-envs") or []:
        if found := re.match(r"""([\w\[\]-]+).*extra == ['"](\w+)['"]""", line):
            declared[found[2]].add(found[1])
    del declared["dev"]
    assert {use.extra: {*use.packages} for use in USES if use.extra} == declared


def test_one_screen_says_what_works(capsys: Capture) -> None:
    out = read(capsys, "info")
    assert out.startswith(f"atari-envs {atari.__version__}, CPython {sys.version.split()[0]}, ")
    assert row(out, "native core").startswith("plays; SIMD ")
    assert row(out, "ale-py's core").startswith("plays; ale-py 0." if ALE is None else ALE)
    assert row(out, "ROM files") == f"{len(roms.installed())} of 108 games"
    assert out.splitlines()[-1].startswith("`atari info --games` lists the games")


def test_with_everything_missing_it_is_still_one_screen(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked(monkeypatch, *(module for use in USES for module in use.packages.values()))
    monkeypatch.setattr(sys, "executable", "/usr/bin/python3")
    monkeypatch.setattr(installation.platform, "system", lambda: "Linux")
    monkeypatch.setattr(shelf, "PARTS", Path("none"))
    lines = read(capsys, "info").splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    out = "\n".join(lines)
    for use in USES:
        assert row(out, use.name).startswith("missing: pip install ")
    assert row(out, "page (atari web)") == "missing: scripts/web builds it in a clone (Emscripten)"
    assert row(out, "Ray and RLlib") == "missing: pip install 'ray[rllib]' torch"
    assert "pip is `/usr/bin/python3 -m pip`" in lines
    assert "PyTorch's build for CPUs is smaller: pytorch.org/get-started has its command" in lines


def test_the_command_has_the_missing_packages_alone(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installation, "USES", [use for use in USES if use.extra in ("lab", "video")])
    blocked(monkeypatch, "anywidget", "av")
    out = read(capsys, "info")
    assert re.fullmatch(r"aiohttp [\d.]+, tomli-w [\d.]+; missing: pip install anywidget", row(out, "inspector"))
    assert row(out, "videos with sound") == "missing: pip install av"
    assert "pip is `" in out
    assert "PyTorch" not in out
    video, lab = read_json(capsys, "info")["uses"]
    assert video == {"use": "videos with sound", "extra": "video", "installed": {}, "missing": ["av"]}
    assert lab["missing"] == ["anywidget"]
    assert [*lab["installed"]] == ["aiohttp", "tomli-w"]


def test_pip_is_named_only_if_something_is_missing(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installation, "USES", [use for use in USES if use.name == "videos with sound"])
    monkeypatch.setattr(installation, "_error_of_core", lambda name: None)
    assert "pip" not in read(capsys, "info")
    monkeypatch.undo()
    blocked(monkeypatch, "ale_py")
    out = read(capsys, "info")
    assert row(out, "ale-py's core") == "missing: pip install --upgrade ale-py"
    assert "pip is `" in out


def test_without_rom_files_the_cores_say_so(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    def find(*_: object) -> None:
        raise FileNotFoundError("there is no ROM file of pong")

    monkeypatch.setattr("atari.cores.native.find", find)
    monkeypatch.setattr("atari.roms.installed", dict)
    out = read(capsys, "info")
    assert row(out, "native core") == "there is no ROM file of pong"
    assert row(out, "ROM files") == "0 of 108 games; `atari roms --help` says how to add them"
    assert read_json(capsys, "info")["cores"] == {"native": "there is no ROM file of pong", "ale": ALE}


@pytest.mark.parametrize("built", [True, False])
def test_whether_the_page_is_built(
    built: bool, capsys: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(shelf, "PARTS", tmp_path)
    if built:
        (tmp_path / "core.wasm").touch()
    assert read_json(capsys, "info")["page"] is built
    assert (row(read(capsys, "info"), "page (atari web)") == "here") is built
