"""`identify` recognises every shipped ROM, and describes any other file with the most similar game."""

import gzip
import hashlib
import random
from pathlib import Path

import pytest

from atari import roms
from atari.games.catalog import games
from atari.roms.identification import recognise


def test_all_shipped_roms_are_recognised(shipped: Path, tmp_path: Path) -> None:
    files = sorted(shipped.glob("*.bin"))
    assert len(files) == 108
    for file in files:
        image = file.read_bytes()
        (tmp_path / "anything").write_bytes(gzip.compress(image))
        for given in (file, str(file), tmp_path / "anything"):
            found = roms.identify(given)
            assert found.game is games[file.stem]
            assert found.nearest is None
            assert str(found) == f"{given} is {games[file.stem].title}"
            assert (found.name, found.size) == (str(given), len(image))
            assert found.md5 == hashlib.md5(image).hexdigest() == games[file.stem].rom.md5
            assert found.sha256 == hashlib.sha256(image).hexdigest() == games[file.stem].rom.sha256


def _changed(image: bytes, count: int) -> bytes:
    """`image` with `count` bytes made different."""
    changed = bytearray(image)
    for index in random.Random(0).sample(range(len(image)), count):
        changed[index] ^= 0x55
    return bytes(changed)


_NEAREST = "is unknown, and nearest to Breakout"
_MOST_ARE_HERE = "2,045 of its 2,048 bytes are here, in a file of 2,100"
_NOISE = random.Random(1).randbytes(4096)


@pytest.mark.parametrize(
    ("make", "nearest", "verdict"),
    [
        (lambda rom: b"", None, "is empty"),
        (lambda rom: b"\x00", None, "is no game: its 1 bytes are all 0x00"),
        (lambda rom: b"\xff" * 4096, None, "is no game: its 4,096 bytes are all 0xff"),
        (lambda rom: rom[:40], None, "is unknown: its 40 bytes are near to no known game"),
        (lambda rom: _NOISE, None, "is unknown: its 4,096 bytes are near to no known game"),
        (lambda rom: rom[:64], "breakout", "is Breakout cut short: only the first 64 of 2,048 bytes"),
        (lambda rom: rom[:2047], "breakout", "is Breakout cut short: only the first 2,047 of 2,048 bytes"),
        (lambda rom: rom[1000:], "breakout", "is Breakout cut short: only the last 1,048 of 2,048 bytes"),
        (lambda rom: rom[500:1500], "breakout", "is Breakout cut short: only the middle 1,000 of 2,048 bytes"),
        (lambda rom: rom * 2, "breakout", "is Breakout repeated 2 times: 4,096 bytes instead of 2,048"),
        (lambda rom: rom * 16, "breakout", "is Breakout repeated 16 times: 32,768 bytes instead of 2,048"),
        (lambda rom: bytes(128) + rom, "breakout", "is Breakout with 128 bytes before it that do not belong to it"),
        (lambda rom: rom + b"\n", "breakout", "is Breakout with 1 bytes after it that do not belong to it"),
        (
            lambda rom: b"header" + rom + _NOISE,
            "breakout",
            "is Breakout with 6 bytes before and 4,096 bytes after it that do not belong to it",
        ),
        (lambda rom: _changed(rom, 1), "breakout", f"{_NEAREST}: 1 of 2,048 bytes differ"),
        (lambda rom: _changed(rom, 1200), "breakout", f"{_NEAREST}: 1,200 of 2,048 bytes differ"),
        (lambda rom: _changed(rom, 3) + bytes(52), "breakout", f"{_NEAREST}: {_MOST_ARE_HERE}"),
        (lambda rom: bytes(52) + _changed(rom, 3), "breakout", f"{_NEAREST}: {_MOST_ARE_HERE}"),
        (lambda rom: _changed(rom, 1800), None, "is unknown: its 2,048 bytes are near to no known game"),
    ],
)
def test_what_is_no_rom_is_described(make, nearest, verdict, breakout: bytes, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    file = tmp_path / "file.bin"
    file.write_bytes(make(breakout))
    found = roms.identify(file)
    assert str(found) == f"{file} {verdict}"
    assert found.game is None
    assert found.nearest is (games[nearest] if nearest else None)
    assert found.size == len(make(breakout))


@pytest.mark.parametrize("game", sorted(games))
def test_a_flipped_bit_and_a_cut_are_traced_to_every_game(game: str, known: dict[str, bytes]) -> None:
    image = known[game]
    assert recognise("x", _changed(image, 1), known).nearest is games[game]
    found = recognise("x", image[: len(image) * 3 // 4], known)
    assert found.nearest is games[game]
    assert "cut short" in found.verdict


def test_a_piece_that_games_share_names_them(shipped: Path, tmp_path: Path) -> None:
    piece = (shipped / "atlantis.bin").read_bytes()[:64]
    assert (shipped / "atlantis2.bin").read_bytes()[:64] == piece
    (tmp_path / "piece").write_bytes(piece)
    found = roms.identify(tmp_path / "piece")
    assert found.verdict == "is Atlantis or Atlantis II cut short: only the first 64 of 4,096 bytes"


def test_of_several_games_the_likelier_is_named() -> None:
    piece = bytes(range(100))
    known = {"pong": b"?" + piece + b"?", "breakout": piece + b"??"}
    assert recognise("x", piece, known).nearest is games["breakout"]
    known = {"pong": piece, "breakout": piece + b"?", "asterix": piece[1:]}
    assert recognise("x", b"!" + piece + b"?!", known).nearest is games["breakout"]


@pytest.mark.usefixtures("bare")
def test_without_other_roms_the_hash_identifies(tmp_path: Path, breakout: bytes) -> None:
    (tmp_path / "a").write_bytes(breakout)
    (tmp_path / "b").write_bytes(breakout[1:])
    assert roms.identify(tmp_path / "a").game is games["breakout"]
    assert roms.identify(tmp_path / "b").verdict == "is unknown: its 2,047 bytes are near to no known game"


def test_what_cannot_be_read_raises(tmp_path: Path, unreadable: Path, breakout: bytes) -> None:
    with pytest.raises(IsADirectoryError):
        roms.identify(tmp_path)
    with pytest.raises(FileNotFoundError):
        roms.identify(tmp_path / "nothing")
    with pytest.raises(PermissionError):
        roms.identify(unreadable)
    packed = gzip.compress(breakout)
    for damaged in (packed[:-9], packed[:500] + b"?" + packed[501:], packed + b"more", packed[:-8] + bytes(8)):
        (tmp_path / "a").write_bytes(damaged)
        with pytest.raises(ValueError, match="a is a damaged gzip file"):
            roms.identify(tmp_path / "a")
