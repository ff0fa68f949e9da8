"""The output of commands: texts that come from files and names of files cannot steer a terminal."""

import sys
import zipfile
from pathlib import Path

import pytest
from cli_tools import Capture, Patch

import atari
from atari.cli import main

ESCAPE = "\x1b]0;changed\x07"
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no file has such a name")


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: Patch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "home"))


def printed(capsys: Capture, *words: str) -> str:
    """What a command prints, which has no control characters."""
    main(words)
    out, err = capsys.readouterr()
    assert (out + err).replace("\n", "").replace("\t", "").isprintable()
    return out + err


def test_names_of_files(tmp_path: Path, capsys: Capture) -> None:
    definition = (Path(atari.games.__path__[0]) / "data" / "breakout.toml").read_text(encoding="utf-8")
    file = tmp_path / f"{ESCAPE}.toml"
    file.write_text(definition, encoding="utf-8")
    assert printed(capsys, "info", str(file)).startswith(r"\x1b]0;changed\x07: Breakout")
    file.write_text(definition.replace('"Breakout"', '"Break\\u001bout"'), encoding="utf-8")
    assert r"\x1b]0;changed\x07.toml: title has the control character '\x1b'" in printed(capsys, "info", str(file))
    assert r"\x1b]0" in printed(capsys, "info", f"{ESCAPE}.mp4")
    assert r"\x1b]0" in printed(capsys, "replay", "show", f"{ESCAPE}.a26r")


def test_names_in_folders_and_archives(tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    folder = tmp_path / "given"
    folder.mkdir()
    (folder / f"{ESCAPE}.bin").write_bytes(b"nothing")
    with zipfile.ZipFile(folder / f"{ESCAPE}.zip", "w") as archive:
        archive.writestr(f"{ESCAPE}.bin", b"nothing")
    assert printed(capsys, "roms", "import", str(folder)).count(r"\x1b]0;changed\x07") == 3
    assert r"\x1b]0" in printed(capsys, "roms", "identify", str(folder / f"{ESCAPE}.bin"))
    monkeypatch.setenv("ATARI_ROMS", str(folder))
    assert "breakout" in printed(capsys, "roms", "list")


def test_other_alphabets_are_printed(tmp_path: Path, capsys: Capture) -> None:
    definition = (Path(atari.games.__path__[0]) / "data" / "breakout.toml").read_text(encoding="utf-8")
    (tmp_path / "own.toml").write_text(definition.replace('"Breakout"', '"ブロック崩し, cassé"'), encoding="utf-8")
    assert "own: ブロック崩し, cassé" in printed(capsys, "info", "own.toml")
