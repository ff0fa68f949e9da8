"""`atari web`: pages with replays, games of policies, and games of one's own; and what is refused."""

import json
import re
import shutil
import zlib
from binascii import crc_hqx
from pathlib import Path
from typing import Any

import pytest
from cli_tools import Capture, Patch, read, refused
from page_parts import CATCH, parts
from replay_tools import full_disk, record

import atari
from atari.cli import main
from atari.multiplayer.core import MultiplayerCore
from atari.recording import RecordReplay, Replay
from atari.web import folder as folder_module
from atari.web import shelf
from atari.web.film import frames_of

FULL_TABLE = shelf.whole_table


@pytest.fixture(autouse=True)
def built(tmp_path_factory: pytest.TempPathFactory, monkeypatch: Patch) -> None:
    """The parts of the page, and a table of two games, which takes less time than that of all."""
    built = parts(tmp_path_factory.mktemp("web") / "parts")
    monkeypatch.setattr(shelf, "PARTS", built)
    table = [atari.games["pong"], atari.games.resolve(built / "catch.toml")]
    monkeypatch.setattr(folder_module, "whole_table", lambda: table)


@pytest.fixture
def own(folder: Path) -> Path:
    """The definition of a game of one's own, with its ROM, and a replay of it."""
    shutil.copy(CATCH / "catch.toml", folder / "own.toml")
    shutil.copy(CATCH / "catch.bin", folder / "own.bin")
    record(folder / "own.a26r", str(folder / "own.toml"), 20)
    return folder / "own.toml"


def written(capsys: Capture, *words: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """What `atari web` prints, and the shelf that it writes."""
    assert main(["web", *words, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    return facts, json.loads(Path(facts["folder"], "shelf.json").read_text(encoding="utf-8"))


def test_the_page_alone(folder: Path, capsys: Capture, monkeypatch: Patch) -> None:
    monkeypatch.setattr(folder_module, "whole_table", FULL_TABLE)
    facts, shelf_ = written(capsys)
    assert facts["folder"] == str(folder / "page")
    assert facts["file"] == str(folder / "page" / "atari.html")
    assert facts["file_bytes"] == (folder / "page" / "atari.html").stat().st_size
    sizes = [path.stat().st_size for path in (folder / "page").rglob("*") if path.is_file()]
    assert facts["bytes"] == sum(sizes) - facts["file_bytes"]
    assert shelf_ == {"format": 1, "replays": [], "roms": ["catch.bin"]}
    assert {path.stem for path in (folder / "page" / "table" / "games").iterdir()} == {*atari.games, "catch"}


def test_replays_with_films(folder: Path, capsys: Capture) -> None:
    record(folder / "game.a26r", "breakout", 100)
    (folder / "other").mkdir()
    record(folder / "other" / "game.a26r", "pong", 30)
    facts, shelf_ = written(capsys, "game.a26r", "other/game.a26r", "--seconds", "5", "-o", "out")
    assert [one["name"] for one in shelf_["replays"]] == [one["name"] for one in facts["replays"]] == ["game", "game-2"]
    assert [one["game"] for one in shelf_["replays"]] == ["breakout", "pong"]
    assert [one["film_seconds"] for one in facts["replays"]] == [5, 2]
    for one, source in zip(shelf_["replays"], ["game.a26r", "other/game.a26r"], strict=True):
        assert (folder / "out" / one["replay"]).read_bytes() == (folder / source).read_bytes()
        assert re.fullmatch(r"(Breakout|Pong): \d+ points?", one["title"])
    assert frames_of((folder / "out" / "replays" / "game.film").read_bytes()) == 300
    _, shelf_ = written(capsys, "game.a26r", "--seconds", "0", "-o", "out")
    assert [one["film"] for one in shelf_["replays"]] == [None]
    assert [path.name for path in (folder / "out" / "replays").iterdir()] == ["game.a26r"]


def test_what_is_printed(folder: Path, capsys: Capture) -> None:
    record(folder / "game.a26r", "pong", 30)
    lines = read(capsys, "web", "game.a26r", "-o", "out").splitlines()
    assert re.fullmatch(rf"{folder}/out/atari\.html  [\d,]+ bytes; open it in a browser, or send it", lines[0])
    assert re.fullmatch(rf"{folder}/out  [\d,]+ bytes without this file; copy the folder to any web server", lines[1])
    assert lines[2].split() == ["link", "title", "replay", "film"]
    assert re.fullmatch(r"  #show=game  Pong: -?\d points?  +[\d,]+ bytes +2\.0 s, [\d,]+ bytes", lines[3])
    assert len(lines) == 4


def test_a_game_of_a_policy(folder: Path, capsys: Capture, monkeypatch: Patch) -> None:
    pytest.importorskip("torch")
    run = Path(__file__).parents[2] / "examples" / "breakout-pqn"
    facts, _ = written(capsys, str(run), "--seconds", "2")
    assert [one["name"] for one in facts["replays"]] == ["breakout-pqn"]
    path = folder / "page" / "replays" / "breakout-pqn.a26r"
    replay = Replay.load(path)
    assert (replay.complete, len(replay.episodes)) == (True, 1)
    assert replay.verify()
    assert main(["record", "breakout", "--policy", str(run), "-o", "same.a26r"]) == 0
    assert [*replay.episodes] == [*Replay.load("same.a26r").episodes]
    assert facts["replays"][0]["title"] == f"Breakout: {replay.episodes[0].score} points"


def test_a_game_of_ones_own(own: Path, folder: Path, capsys: Capture) -> None:
    facts, shelf_ = written(capsys, "own.a26r", "own.toml")
    assert shelf_["roms"] == ["catch.bin", "roms/own.bin"]
    assert (folder / "page" / "roms" / "own.bin").read_bytes() == (CATCH / "catch.bin").read_bytes()
    assert shelf_["replays"][0]["game"] == "own"
    assert facts["replays"][0]["film_bytes"] > 0
    assert (folder / "page" / "table" / "games" / "own.json").exists()
    refused(capsys, ["web", "own.a26r", "-o", "out"], "is a replay of 'own', a game of its own; name its definition")
    (folder / "other").mkdir()
    for ending in ("toml", "bin"):
        shutil.copy(folder / f"own.{ending}", folder / "other")
        shutil.copy(folder / f"own.{ending}", folder / f"my own.{ending}")
    refused(capsys, ["web", "own.toml", "other/own.toml"], "own.toml and other/own.toml both define 'own'; leave one")
    refused(capsys, ["web", "my own.toml"], "names of letters, digits, '_', '-' and '.', got")
    shutil.copy(atari.roms.find("pong"), folder / "own.bin")
    refused(capsys, ["web", "own.toml"], "is that of Pong, which a page must not contain")
    (folder / "own.bin").unlink()
    refused(capsys, ["web", "own.toml", "-o", "out"], "names no hash to search for")
    assert not (folder / "out").exists()


def test_a_replay_without_the_rom(folder: Path, capsys: Capture, monkeypatch: Patch) -> None:
    record(folder / "game.a26r", "pong", 30)
    points = Replay.load("game.a26r").episodes[0].score

    def missing(*_: Any, **__: Any) -> Path:
        raise FileNotFoundError("no ROM file of Pong")

    monkeypatch.setattr("atari.recording.replay.header.rom_md5", missing)
    assert main(["web", "game.a26r", "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == (
        "atari: warning: game.a26r is on the page without a film, because its game cannot be played here: no ROM file "
        "of Pong\n"
    )
    assert json.loads(out)["replays"][0]["film_seconds"] == 0
    (row,) = json.loads((folder / "page" / "shelf.json").read_text())["replays"]
    assert (row["film"], row["title"]) == (None, f"Pong: {points} point{'s' * (points != 1)}")


def test_a_replay_that_was_cut(folder: Path, capsys: Capture) -> None:
    path = record(folder / "game.a26r", "pong", 100)
    path.write_bytes(path.read_bytes()[:-40])
    assert main(["web", "game.a26r", "--json"]) == 0
    out, err = capsys.readouterr()
    with pytest.warns(UserWarning, match="was cut"):
        frames = Replay.load(path).frames_total
    assert err == f"atari: warning: game.a26r was cut while it was recorded; its first {frames} frames are whole\n"
    assert json.loads(out)["replays"][0]["title"].startswith("Pong: ")


def damaged(folder: Path) -> None:
    data = bytearray(record(folder / "bad.a26r", "pong", 30).read_bytes())
    data[len(data) // 2] ^= 255
    (folder / "bad.a26r").write_bytes(data)


def of_an_unknown_game(folder: Path) -> None:
    data = record(folder / "bad.a26r", "pong", 5).read_bytes()
    size = int.from_bytes(data[9:13], "little")
    payload = data[19 : 19 + size].replace(b'"pong"', b'"pung"', 1)
    head = b"H" + len(payload).to_bytes(4, "little") + zlib.crc32(payload).to_bytes(4, "little")
    crc = crc_hqx(head, 0).to_bytes(2, "little")
    (folder / "bad.a26r").write_bytes(data[:8] + head + crc + payload + data[19 + size :])


def empty(folder: Path) -> None:
    record(folder / "bad.a26r", "pong", 0)


def of_four(folder: Path) -> None:
    with RecordReplay(MultiplayerCore("warlords", players=4), folder / "bad.a26r") as match:
        match.reset()
        match.act_players([0, 0, 0, 0])


def no_policy(folder: Path) -> None:
    (folder / "bad.a26r").unlink(missing_ok=True)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (damaged, "the replay is damaged"),
        (of_an_unknown_game, "bad.a26r is a replay of 'pung', a game of its own; name its definition (.toml), too"),
        (empty, "bad.a26r has no frames"),
        (of_four, "bad.a26r has 4 players; a page plays games of one or two"),
        (no_policy, "there is no bad.a26r; a SOURCE is a replay, a run folder, the file of a policy"),
    ],
)
def test_a_replay_that_is_refused(make: Any, sentence: str, folder: Path, capsys: Capture) -> None:
    make(folder)
    refused(capsys, ["web", "bad.a26r"], sentence)
    assert not (folder / "page").exists()


def test_a_policy_that_names_no_game(folder: Path, capsys: Capture) -> None:
    torch = pytest.importorskip("torch")
    torch.jit.script(torch.nn.Linear(128, 6)).save("model.pt")
    refused(capsys, ["web", "model.pt"], "model.pt does not say which game it plays")
    assert "page" not in [path.name for path in folder.iterdir()]


def test_a_package_without_the_page(folder: Path, capsys: Capture, monkeypatch: Patch) -> None:
    monkeypatch.setattr(shelf, "PARTS", folder / "missing")
    refused(capsys, ["web"], "this package was built without the page; run scripts/web in a clone of the repository")
    assert list(folder.iterdir()) == []


def test_folders_that_are_refused(folder: Path, capsys: Capture) -> None:
    (folder / "page").mkdir()
    (folder / "page" / "index.html").write_text("mine")
    refused(capsys, ["web"], "page has other files, such as index.html, and no page of `atari web`; name a new")
    refused(capsys, ["web", "-o", "page/index.html"], "index.html is a file; a page is written into a folder")
    with full_disk(20_000):
        refused(capsys, ["web", "-o", "new"], "File too large")
    assert sorted(path.name for path in folder.iterdir()) == ["page"]


def test_seconds_are_checked(capsys: Capture) -> None:
    for text in ("-1", "601", "x"):
        refused(capsys, ["web", "--seconds", text], "is not a number within 0..600", code=2)
