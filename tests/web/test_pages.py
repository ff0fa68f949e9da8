"""Pages: their files, their two forms, and the folder that they are written into. `test_page.py` opens them."""

import base64
import errno
import gzip
import hashlib
import html
import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from page_parts import CATCH, CORE, parts
from replay_tools import full_disk

import atari
from atari.roms.image import md5
from atari.web import folder as folder_module
from atari.web import shelf
from atari.web.bundle import one_file, site
from atari.web.folder import write_page
from atari.web.shelf import Shown, page_files, unique

PONG, BREAKOUT = atari.games["pong"], atari.games["breakout"]


@pytest.fixture(autouse=True)
def built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The parts of the page, and a table of two games, which takes less time than that of all."""
    built = parts(tmp_path / "parts")
    monkeypatch.setattr(shelf, "PARTS", built)
    monkeypatch.setattr(folder_module, "whole_table", lambda: [PONG, atari.games.resolve(built / "catch.toml")])
    return built


def of_game(game: str, name: str = "game", film: bytes | None = b"a film", title: str = "A game") -> Shown:
    return Shown(name, title, atari.games[game], f"a replay of {game}".encode(), film)


def own_game(folder: Path, game: str = "own", rom: bytes = b"") -> Path:
    """The definition of a game of one's own, and its ROM beside it."""
    shutil.copy(CATCH / "catch.toml", folder / f"{game}.toml")
    (folder / f"{game}.bin").write_bytes(rom or (CATCH / "catch.bin").read_bytes()[::-1])
    return folder / f"{game}.toml"


def inside(page: str) -> dict[str, bytes]:
    """The files that are packed into one file."""
    found = re.findall(r'<script type="application/octet-stream" id="file:([^"]+)">([^<]*)</script>', page)
    packed = {name: base64.b64decode(text) for name, text in found}
    return {name: data if name == "worklet.js" else gzip.decompress(data) for name, data in packed.items()}


def test_the_shelf() -> None:
    files = page_files([of_game("pong", "a"), of_game("breakout", "b", None, "Another")], [])
    assert json.loads(files["shelf.json"]) == {
        "format": 1,
        "replays": [
            {"name": "a", "title": "A game", "game": "pong", "replay": "replays/a.a26r", "film": "replays/a.film"},
            {"name": "b", "title": "Another", "game": "breakout", "replay": "replays/b.a26r", "film": None},
        ],
        "roms": [],
    }
    assert files["replays/a.a26r"] == b"a replay of pong"
    assert files["replays/a.film"] == b"a film"
    assert "replays/b.film" not in files
    assert list(json.loads(files["table/index.json"])["games"]) == ["pong", "breakout"]
    assert files["core.wasm"] == CORE
    assert not {"catch.bin", "catch.toml"} & files.keys()


def test_names_and_titles_differ() -> None:
    names = ["game", "Game", "game-2", "x y/../<ü>", "...", "a" * 200]
    found = unique([of_game("pong", name) for name in names])
    assert [one.name for one in found] == ["game", "Game-2", "game-2-2", "x-y", "pong", "a" * 80]
    assert found[0].title == "A game"
    assert len({one.title for one in found}) == len(found)
    assert unique(found) == found


def test_only_roms_of_own_games_are_on_the_page(tmp_path: Path) -> None:
    catch, own = (atari.games.resolve(path) for path in (shelf.PARTS / "catch.toml", own_game(tmp_path)))
    files = page_files([of_game("pong")], [*atari.games.values(), catch, own])
    assert json.loads(files["shelf.json"])["roms"] == ["catch.bin", "roms/own.bin"]
    assert files["roms/own.bin"] == (tmp_path / "own.bin").read_bytes()
    assert files["catch.bin"] == (CATCH / "catch.bin").read_bytes()
    others = {game.rom.md5 for game in atari.games.values()}
    assert not others & {md5(data) for data in files.values()}


def test_the_rom_of_another_game_is_refused(tmp_path: Path) -> None:
    own = atari.games.resolve(own_game(tmp_path, rom=atari.roms.find("pong").read_bytes()))
    with pytest.raises(ValueError, match=r"the ROM of .*own\.toml is that of Pong, which a page must not contain"):
        page_files([], [own])


def test_a_package_without_the_page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(shelf, "PARTS", tmp_path / "missing")
    with pytest.raises(FileNotFoundError, match="built without the page; run scripts/web"):
        write_page(tmp_path / "page")
    assert not (tmp_path / "page").exists()


def test_the_one_file_contains_all(tmp_path: Path) -> None:
    files = page_files([of_game("pong")], [PONG, atari.games.resolve(own_game(tmp_path))])
    page = one_file(files)
    packed = inside(page)
    assert packed["table/table.json"] == gzip.decompress(files["table/table.json.gz"])
    same = ["core.wasm", "shelf.json", "table/index.json", "roms/own.bin", "table/games/own.json", "worklet.js"]
    same += ["replays/game.a26r", "replays/game.film"]
    assert {name: packed[name] for name in same} == {name: files[name] for name in same}
    assert len(packed) == len(same) + 1
    code = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    style = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)
    assert (len(code), len(style)) == (1, 1)
    for text in (*code, *style):
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in re.findall('content="(default-src[^"]*)"', page)[0]
    assert not re.search(r'^\s*(import|export)\b|(src|href)="(?!data:)', page, re.MULTILINE)


def test_the_site_names_what_it_loads_first(tmp_path: Path) -> None:
    files = site(page_files([of_game("pong")], [atari.games.resolve(own_game(tmp_path))]))
    page = files["index.html"].decode()
    loads = re.findall(r'<link rel="(?:module)?preload" href="([^"]*)"', page)
    assert loads[-4:] == ["core.wasm", "shelf.json", "table/index.json", "roms/own.bin"]
    kept = json.loads(files["files.json"])
    assert {*loads, "page.css", "table/games/own.json", "worklet.js"} <= {*kept}
    assert {*kept} - {"./"} <= files.keys()
    assert not [name for name in kept if name.startswith("replays/")]


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("main.js", 'import * as all from "./dom.js";\n', "main.js has a form of import that the bundle does not have"),
        ("dom.js", "export { h };\n", "dom.js has a form of export"),
        ("page.css", "/* </style> */", "the end of a script or a style in a text"),
        ("index.html", "<!-- loads -->\n", "index.html has 2 times"),
    ],
)
def test_a_source_that_cannot_be_one_file(built: Path, name: str, text: str, problem: str) -> None:
    (built / name).write_text(text + (built / name).read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(problem)):
        one_file(page_files([], []))


def test_a_title_is_text_alone() -> None:
    files = page_files([of_game("pong", title="</script><script>alert(1)</script>")], [])
    page = one_file(files)
    assert "alert(1)" not in page
    assert json.loads(inside(page)["shelf.json"])["replays"][0]["title"] == "</script><script>alert(1)</script>"
    assert html.unescape(page) == page


def test_a_page_is_written_and_replaced(tmp_path: Path) -> None:
    page = tmp_path / "new" / "page"
    own = atari.games.resolve(own_game(tmp_path))
    sizes = write_page(page, [of_game("pong", "first")], [own])
    written = {path.relative_to(page).as_posix(): path.stat().st_size for path in page.rglob("*") if path.is_file()}
    assert written == sizes
    assert {"index.html", "atari.html", "replays/first.film", "roms/own.bin", "table/games/pong.json"} <= sizes.keys()
    (page / "article.html").write_text("mine")
    (page / "replays" / "mine.a26r").write_text("mine")
    write_page(page, [of_game("pong", "second")])
    left = {path.relative_to(page).as_posix() for path in page.rglob("*") if path.is_file()}
    assert {"article.html", "replays/mine.a26r", "replays/second.film"} <= left
    assert not {"replays/first.film", "replays/first.a26r", "roms/own.bin"} & left
    assert sorted(path.name for path in page.parent.iterdir()) == ["page"]


def test_a_folder_with_other_files(tmp_path: Path) -> None:
    folder = tmp_path / "site"
    folder.mkdir()
    (folder / "index.html").write_text("mine")
    with pytest.raises(FileExistsError, match=r"site has other files, such as index\.html, and no page"):
        write_page(folder)
    with pytest.raises(NotADirectoryError, match="is a file"):
        write_page(folder / "index.html")
    assert [path.read_text() for path in folder.iterdir()] == ["mine"]


def _no_space(monkeypatch: pytest.MonkeyPatch) -> Any:
    usage = shutil.disk_usage("/")
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage._replace(free=1000))
    return pytest.raises(OSError, match="No space left on device")


def _small_files(monkeypatch: pytest.MonkeyPatch) -> Any:
    return pytest.raises(OSError, match="File too large")


@pytest.mark.parametrize("disk", [_no_space, _small_files])
def test_a_full_disk_leaves_the_folder(
    disk: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "page"
    write_page(page, [of_game("pong", "first")])
    before = {path: path.read_bytes() for path in page.rglob("*") if path.is_file()}
    with disk(monkeypatch) as caught, full_disk(20_000):
        write_page(page, [of_game("pong", "second")])
    assert caught.value.errno in (errno.ENOSPC, errno.EFBIG)
    assert str(caught.value.filename).startswith(str(page))
    assert {path: path.read_bytes() for path in page.rglob("*") if path.is_file()} == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["page", "parts"]


def test_the_whole_table_has_all_games() -> None:
    assert [game.id for game in shelf.whole_table()] == [*atari.games, "catch"]
