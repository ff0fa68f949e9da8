"""`atari roms`: the commands around `atari.roms`, on real files."""

import json
import os
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import pytest
from cli_tools import Capture, Patch, read, read_json, refused

import atari
from atari.cli import main
from atari.roms.locations import path


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: Patch) -> Path:
    """The user's own folder, in a home directory of the test."""
    monkeypatch.delenv("ATARI_ROMS", raising=False)
    for name in ("HOME", "USERPROFILE", "LOCALAPPDATA", "XDG_DATA_HOME"):
        monkeypatch.setenv(name, str(tmp_path / "home"))
    folder: Path = path()
    return folder


@pytest.fixture
def collection(tmp_path: Path) -> Path:
    """A folder with two games under other names, and two files that are not ROMs."""
    folder = tmp_path / "collection"
    folder.mkdir()
    (folder / "Pong (1977).a26").write_bytes(atari.roms.find("pong").read_bytes())
    (folder / "b.rom").write_bytes(atari.roms.find("breakout").read_bytes())
    (folder / "cut.bin").write_bytes(atari.roms.find("breakout").read_bytes()[:1000])
    (folder / "notes.txt").write_text("nothing")
    return folder


def test_list_shows_a_file_for_every_game(capsys: Capture) -> None:
    lines = read(capsys, "roms", "list").splitlines()
    assert [line.split()[0] for line in lines] == list(atari.games)
    files = read_json(capsys, "roms", "list")
    assert files == {game: str(atari.roms.find(game)) for game in atari.games}


def test_verify_finds_all_right(capsys: Capture) -> None:
    assert read(capsys, "roms", "verify").endswith("108 of 108 ROM files are right\n")


def test_verify_of_some_games_as_json(capsys: Capture) -> None:
    checks = read_json(capsys, "roms", "verify", "pong", "qbert")
    assert list(checks) == ["pong", "qbert"]
    assert checks["pong"]["status"] == "ok"
    assert checks["pong"]["md5"] == atari.games["pong"].rom.md5


def test_missing_and_wrong_files_fail(collection: Path, monkeypatch: Patch, capsys: Capture) -> None:
    (collection / "cut.bin").rename(collection / "asterix.bin")
    monkeypatch.setenv("ATARI_ROMS", str(collection))
    monkeypatch.setattr("atari.roms.locations._ale_py_folders", lambda: ())
    assert main(["roms", "verify", "pong", "asterix", "seaquest", "--json"]) == 1
    checks = json.loads(capsys.readouterr().out)
    assert [check["status"] for check in checks.values()] == ["ok", "wrong", "missing"]
    assert main(["roms", "verify", "pong", "seaquest"]) == 1
    assert capsys.readouterr().out.endswith("1 of 2 ROM files are right\n")
    files = read_json(capsys, "roms", "list")
    assert files["pong"] == str(collection / "Pong (1977).a26")
    assert files["seaquest"] is None
    assert "missing" in next(line for line in read(capsys, "roms", "list").splitlines() if line.startswith("seaquest"))


def test_verify_of_an_unknown_game_suggests_the_nearest(capsys: Capture) -> None:
    refused(capsys, ["roms", "verify", "pongg"], "there is no game 'pongg'; did you mean 'pong'?")


def test_identify_names_the_game(collection: Path, capsys: Capture) -> None:
    assert read(capsys, "roms", "identify", str(collection / "b.rom")) == f"{collection / 'b.rom'} is Breakout\n"


def test_identify_of_a_damaged_file_says_what_it_is_and_fails(collection: Path, capsys: Capture) -> None:
    files = [str(collection / "b.rom"), str(collection / "cut.bin")]
    assert main(["roms", "identify", *files]) == 1
    assert "cut.bin is Breakout cut short" in capsys.readouterr().out
    assert main(["roms", "identify", *files, "--json"]) == 1
    good, cut = json.loads(capsys.readouterr().out)
    assert (good["game"], good["size"], good["md5"]) == ("breakout", 2048, atari.games["breakout"].rom.md5)
    assert (cut["game"], cut["nearest"], cut["size"]) == (None, "breakout", 1000)


def test_identify_goes_on_after_a_file_that_cannot_be_read(collection: Path, capsys: Capture) -> None:
    assert main(["roms", "identify", str(collection / "nothing"), str(collection / "b.rom")]) == 1
    captured = capsys.readouterr()
    assert captured.err.startswith("atari: error: ")
    assert str(collection / "nothing") in captured.err
    assert captured.out == f"{collection / 'b.rom'} is Breakout\n"


def test_import_copies_what_it_knows(own: Path, collection: Path, capsys: Capture) -> None:
    out = read(capsys, "roms", "import", str(collection))
    assert "games imported: 2" in out
    assert "files not taken: 2" in out
    assert "cut.bin is Breakout cut short" in out
    assert out.endswith(f"your folder: {own}\n")
    assert sorted(file.name for file in own.iterdir()) == ["breakout.bin", "pong.bin"]
    report = read_json(capsys, "roms", "import", str(collection))
    assert report["imported"] == {}
    assert report["present"] == {game: str(own / f"{game}.bin") for game in ("pong", "breakout")}
    assert len(report["rejected"]) == 2


def test_import_of_many_other_files_shows_some(tmp_path: Path, capsys: Capture) -> None:
    for i in range(23):
        (tmp_path / f"{i}.bin").write_bytes(bytes([i]))
    assert main(["roms", "import", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "games imported: 0\n" in out
    assert "files not taken: 23\n" in out
    assert "  ... and 3 more (all with --json)\n" in out


def test_import_from_nowhere(tmp_path: Path, capsys: Capture) -> None:
    assert not refused(capsys, ["roms", "import", str(tmp_path / "nowhere")], str(tmp_path / "nowhere"))


def test_a_name_that_is_no_text_is_printed(tmp_path: Path) -> None:
    folder = tmp_path / "names"
    folder.mkdir()
    (folder / os.fsdecode(b"\xff")).write_bytes(b"hello")
    command = [sys.executable, "-m", "atari", "roms", "import", str(folder)]
    environment = {**os.environ, "PYTHONIOENCODING": "utf-8:strict", "PYTHONSAFEPATH": "1"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert (done.returncode, done.stderr) == (1, "")
    assert "\\udcff is unknown: its 5 bytes are near to no known game" in done.stdout


def test_install_without_autorom_names_the_extra(monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.setitem(sys.modules, "AutoROM", None)
    refused(capsys, ["roms", "install"], "pip install 'autorom>=0.6'")


def test_install_keeps_the_talk_of_autorom_out_of_the_result(
    own: Path, collection: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    accepted = []

    def download(accept_license: bool, source: Any, folder: str, quiet: bool) -> None:
        accepted.append(accept_license)
        print("I own a license to these Atari 2600 ROMs.")
        (Path(folder) / "pong.bin").write_bytes((collection / "Pong (1977).a26").read_bytes())

    package, module = types.ModuleType("AutoROM"), types.ModuleType("AutoROM.AutoROM")
    package.AutoROM = module  # type: ignore[attr-defined]
    module.main = download  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "AutoROM", package)
    assert main(["roms", "install", "--accept-license", "--json"]) == 0
    captured = capsys.readouterr()
    assert json.loads(captured.out)["imported"] == {"pong": str(own / "pong.bin")}
    assert captured.err == "I own a license to these Atari 2600 ROMs.\n"
    assert accepted == [True]
