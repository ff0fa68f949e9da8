"""`find`, `installed` and `verify` find the right file in any folder, and never return a wrong file."""

import dataclasses
import gzip
import hashlib
import os
import random
import shutil
from pathlib import Path
from typing import Any

import pytest
from ale_py import ALEInterface

import atari
from atari import roms
from atari.games.catalog import games
from atari.roms.locations import folders
from atari.roms.search import Check


def test_every_game_is_found_in_the_wheel_of_ale_py(shipped: Path) -> None:
    found = {game: roms.find(game) for game in games}
    assert len(found) == 108
    assert found == {game: shipped / f"{game}.bin" for game in games}


def test_the_places_are_searched_in_order(
    own: Path, tmp_path: Path, shipped: Path, breakout: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    monkeypatch.setenv("ATARI_ROMS", os.pathsep.join([str(one), "", str(two)]))
    assert folders() == (one, two, own, shipped)
    for folder in (own, two, one):
        folder.mkdir(parents=True)
        (folder / "breakout.bin").write_bytes(breakout)
        assert roms.find("breakout") == folder / "breakout.bin"
    assert roms.find("breakout", shipped / "breakout.bin") == shipped / "breakout.bin"


def test_home_is_understood_in_the_environment_variable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATARI_ROMS", "~/games")
    assert folders()[0] == Path.home() / "games"


@pytest.mark.parametrize(
    "name",
    ["Breakout (1978) (Atari).a26", "BREAKOUT.BIN", "Breakout.rom", "no suffix", "打砖块.bin", "pong.bin.bin", "x.zip"],
)
@pytest.mark.usefixtures("bare")
def test_any_name_will_do(collection: Path, breakout: bytes, name: str) -> None:
    (collection / "another.a26").write_bytes(b"not a game")
    (collection / name).write_bytes(breakout)
    assert roms.find("breakout") == collection / name
    assert roms.find("breakout", collection / name) == collection / name


@pytest.mark.parametrize("name", ["breakout.bin.gz", "breakout.bin", "Breakout (1978).gz", "b"])
@pytest.mark.usefixtures("bare")
def test_gzip_will_do(collection: Path, breakout: bytes, name: str) -> None:
    (collection / name).write_bytes(gzip.compress(breakout))
    assert roms.find("breakout") == collection / name
    assert _minimal_actions(roms.find("breakout")) == 4


@pytest.mark.parametrize("name", ["asterix.bin", "Asterix.A26", "asterix", "asterix.", "asterix.gz"])
def test_a_name_that_misleads_ale_py_is_put_right(own: Path, tmp_path: Path, breakout: bytes, name: str) -> None:
    file = tmp_path / name
    file.write_bytes(breakout)
    assert _minimal_actions(file) == 9, "ale-py no longer takes the rules of Asterix for the name's sake"
    assert roms.find("breakout", file) == own / "breakout.bin"
    assert (own / "breakout.bin").read_bytes() == breakout
    assert _minimal_actions(roms.find("breakout", file)) == 4


def test_a_misleading_name_where_no_copy_can_be_made(own: Path, tmp_path: Path, breakout: bytes) -> None:
    (tmp_path / "asterix.bin").write_bytes(breakout)
    own.parent.write_bytes(b"a file where the folder should be")
    with pytest.raises(PermissionError, match=r"is Breakout, but named as another game.*rename it to breakout\.bin"):
        roms.find("breakout", tmp_path / "asterix.bin")


@pytest.mark.parametrize("hashes", ["", f'[rom]\nmd5 = "{"0" * 32}"\n', "pong's"])
def test_a_game_of_ones_own_never_stores_its_rom(
    own: Path, tmp_path: Path, pong: bytes, breakout: bytes, hashes: str
) -> None:
    """A game file named breakout.toml, played with pong.bin, replaced breakout.bin in the user's folder."""
    own.mkdir(parents=True)
    (own / "breakout.bin").write_bytes(breakout)
    if hashes == "pong's":
        hashes = f'[rom]\nmd5 = "{games["pong"].rom.md5}"\n'
    catch = Path(__file__).parents[2] / "examples" / "catch" / "catch.toml"
    (tmp_path / "breakout.toml").write_text(catch.read_text() + "\n" + hashes)
    (tmp_path / "pong.bin").write_bytes(pong)
    if "000" in hashes:
        with pytest.raises(ValueError, match="is Pong"):
            atari.AtariEnv(tmp_path / "breakout.toml", rom=tmp_path / "pong.bin")
    else:
        atari.AtariEnv(tmp_path / "breakout.toml", rom=tmp_path / "pong.bin").reset()
    assert [(file.name, file.read_bytes()) for file in own.iterdir()] == [("breakout.bin", breakout)]


def test_the_copy_of_a_misleading_name_replaces_nothing(own: Path, tmp_path: Path, breakout: bytes) -> None:
    own.mkdir(parents=True)
    (own / "breakout.bin").write_bytes(b"mine")
    (tmp_path / "asterix.bin").write_bytes(breakout)
    copy = roms.find("breakout", tmp_path / "asterix.bin")
    assert copy.parent == own
    assert copy.read_bytes() == breakout
    assert _minimal_actions(copy) == 4
    assert (own / "breakout.bin").read_bytes() == b"mine"
    assert roms.find("breakout", tmp_path / "asterix.bin") == copy


_LOADED: dict[tuple[str, bytes], int] = {}


def _minimal_actions(file: Path) -> int:
    """The number of ale-py's actions, which depend on the name of a file and its content."""
    key = file.name, file.read_bytes()
    if key not in _LOADED:
        ale = ALEInterface()
        ale.loadROM(file)
        _LOADED[key] = len(ale.getMinimalActionSet())
    return _LOADED[key]


def test_a_relative_path_becomes_absolute(tmp_path: Path, breakout: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "b").write_bytes(breakout)
    monkeypatch.chdir(tmp_path)
    assert roms.find("breakout", "b") == tmp_path / "b"


def test_a_wrong_file_of_the_right_name_is_passed_over(
    collection: Path, shipped: Path, pong: bytes, breakout: bytes
) -> None:
    (collection / "breakout.bin").write_bytes(pong)
    (collection / "breakout.bin.gz").mkdir()
    assert roms.find("breakout") == shipped / "breakout.bin"
    assert roms.find("pong") == collection.parent / "data" / "roms" / "pong.bin", "its name would mislead ale-py"
    (collection / "the real one").write_bytes(breakout)
    assert roms.find("breakout") == collection / "the real one"


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("times", [(0, 0), (5, 0)], ids=["the size and the time stay", "the time changes"])
def test_a_file_that_changes_is_read_again(
    collection: Path, pong: bytes, breakout: bytes, times: tuple[int, int]
) -> None:
    file = collection / "game"
    file.write_bytes(breakout)
    os.utime(file, ns=(0, times[0]))
    assert roms.find("breakout") == file
    file.write_bytes(pong)
    os.utime(file, ns=(0, times[1]))
    if times[0] != times[1]:
        assert roms.find("pong") == file
    with pytest.raises(FileNotFoundError):
        roms.find("breakout")


@pytest.mark.usefixtures("bare")
def test_a_link_is_followed_to_what_it_shows_now(
    collection: Path, tmp_path: Path, pong: bytes, breakout: bytes
) -> None:
    (collection / "link").symlink_to(tmp_path / "target")
    for content, game in ((breakout, "breakout"), (pong, "pong")):
        (tmp_path / "target").write_bytes(content)
        os.utime(tmp_path / "target", ns=(0, len(game)))
        assert roms.find(game) == collection / "link"


@pytest.mark.usefixtures("bare")
def test_hidden_files_are_left_alone(collection: Path, breakout: bytes) -> None:
    (collection / ".breakout.0123456789abcdef").write_bytes(breakout)
    with pytest.raises(FileNotFoundError):
        roms.find("breakout")


@pytest.mark.usefixtures("bare")
def test_nothing_found_says_where_and_what_to_do(own: Path, collection: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        roms.find("breakout")
    assert str(caught.value) == (
        f"no ROM file of Breakout (MD5 f34f08e5eb96e500e851a80be3277a56) in {collection}, {own}; "
        "set ATARI_ROMS to a folder that has it, or run `atari roms import` on that folder"
    )


def test_rubbish_in_a_folder_harms_nothing(collection: Path, shipped: Path, unreadable: Path) -> None:
    (collection / "dangling").symlink_to(collection / "nowhere")
    (collection / "locked").symlink_to(unreadable)
    (collection / "broken.gz").write_bytes(b"\x1f\x8bnonsense")
    (collection / "empty").touch()
    (collection / "folder").mkdir()
    with (collection / "large").open("wb") as file:
        file.truncate(10**12)
    os.mkfifo(collection / "pipe")
    os.mkfifo(collection / "breakout.bin")
    assert roms.find("breakout") == shipped / "breakout.bin"


@pytest.mark.parametrize(
    ("path", "error", "text"),
    [
        ("", IsADirectoryError, "is a folder; give the ROM file in it"),
        ("missing.bin", FileNotFoundError, r"there is no file .*missing\.bin; check the path"),
        ("dangling", FileNotFoundError, "there is no file .*dangling; check the path"),
        ("file/below", FileNotFoundError, "there is no file .*file/below; check the path"),
        ("locked.bin", PermissionError, r"locked\.bin may not be read; give yourself the permission"),
        ("pipe", ValueError, "is a device or a pipe; give a regular file"),
        ("pong.bin", ValueError, r"the ROM of Breakout is needed, but .*/pong\.bin is Pong; without a path"),
        ("cut", ValueError, "is Breakout cut short: only the first 1,500 of 2,048 bytes"),
        (3, TypeError, "not"),
        (b"/breakout.bin", TypeError, "not"),
        (["breakout.bin"], TypeError, "not"),
    ],
)
@pytest.mark.usefixtures("unreadable")
def test_a_wrong_path(
    path: Any, error: type[Exception], text: str, tmp_path: Path, pong: bytes, breakout: bytes
) -> None:
    """Each is an exception, before ale-py sees the file."""
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    os.mkfifo(tmp_path / "pipe")
    for name, content in (("file", b""), ("pong.bin", pong), ("cut", breakout[:1500])):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(error, match=text):
        roms.find("breakout", tmp_path / path if isinstance(path, str) else path)


def test_path_is_in_an_unreadable_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, **options: Any) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "stat", refuse)
    with pytest.raises(PermissionError, match=r"b\.bin may not be read; check the permissions of its folders"):
        roms.find("breakout", tmp_path / "b.bin")


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        (b"", "is empty"),
        (b"\x1f\x8b\x08rubbish", "is a damaged gzip file"),
        (b"PK\x03\x04", "is a zip archive"),
        (bytes(range(200)), "is unknown: its 200 bytes are near to no known game"),
        (b"ab" * 300_000, "has more than 524,288 bytes"),
        (gzip.compress(bytes(10**8)), "has more than 524,288 bytes"),
        (gzip.compress(random.Random(0).randbytes(600_000)), "has more than 524,288 bytes"),
    ],
)
def test_path_is_no_rom(tmp_path: Path, content: bytes, fault: str) -> None:
    file = tmp_path / "breakout.bin"
    file.write_bytes(content)
    with pytest.raises(ValueError, match=rf"breakout\.bin {fault}"):
        roms.find("breakout", file)


@pytest.mark.parametrize(
    ("game", "kind", "text"),
    [
        ("braekout", ValueError, "did you mean 'breakout'?"),
        ("Breakout", ValueError, "did you mean 'breakout'?"),
        ("", ValueError, "there is no game ''"),
        ("../breakout", ValueError, "there is no game '../breakout'"),
        (None, TypeError, "a game is named by a string"),
        (3, TypeError, "a game is named by a string"),
    ],
)
def test_no_game(game: Any, kind: type[Exception], text: str) -> None:
    for function in (roms.find, roms.verify):
        if (function, game) != (roms.verify, None):
            with pytest.raises(kind) as caught:
                function(game)
            assert text in str(caught.value)


def test_installed(own: Path, shipped: Path, breakout: bytes) -> None:
    own.mkdir(parents=True)
    (own / "b.a26").write_bytes(breakout)
    expected = {game: shipped / f"{game}.bin" for game in games} | {"breakout": own / "b.a26"}
    assert roms.installed() == expected


@pytest.mark.usefixtures("bare")
def test_installed_leaves_out_what_is_missing(collection: Path, shipped: Path) -> None:
    assert roms.installed() == {}
    shutil.copy(shipped / "pong.bin", collection)
    assert roms.installed() == {"pong": collection / "pong.bin"}


def test_verify_all(shipped: Path) -> None:
    checks = roms.verify()
    assert list(checks) == list(games)
    for game in games.values():
        image = (shipped / f"{game.id}.bin").read_bytes()
        assert checks[game.id] == Check(
            game=game.id,
            status="ok",
            file=shipped / f"{game.id}.bin",
            md5=hashlib.md5(image).hexdigest(),
            sha256=hashlib.sha256(image).hexdigest(),
            note="",
        )


def test_verify_reports_a_skipped_file(collection: Path, shipped: Path, pong: bytes) -> None:
    file = collection / "breakout.bin"
    file.write_bytes(pong)
    check = roms.verify("breakout")["breakout"]
    assert (check.status, check.file, check.note) == ("ok", shipped / "breakout.bin", f"{file} is Pong")
    file.write_bytes(b"\x1f\x8b")
    assert "breakout.bin is a damaged gzip file" in roms.verify("breakout")["breakout"].note


@pytest.mark.usefixtures("bare")
def test_verify_missing_and_wrong(collection: Path) -> None:
    assert roms.verify("pong") == {"pong": Check("pong", "missing", None, None, None, "")}
    (collection / "pong.bin").touch()
    note = f"{collection / 'pong.bin'} is empty"
    assert roms.verify("pong") == {"pong": Check("pong", "wrong", None, None, None, note)}


def test_verify_sees_a_forged_md5() -> None:
    forged = dataclasses.replace(games["pong"], rom=dataclasses.replace(games["pong"].rom, sha256="0" * 64))
    check = roms.verify(forged)["pong"]
    assert (check.status, check.md5) == ("wrong", games["pong"].rom.md5)
    assert "has the MD5 of Pong but another SHA-256" in check.note
