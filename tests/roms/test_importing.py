"""`import_from` copies every known ROM under its usual name, and does nothing else."""

import gzip
import os
import shutil
import struct
import tracemalloc
import zipfile
from pathlib import Path

import pytest
from env_tools import needs_new_ale_py

from atari import roms
from atari.games.catalog import games


@needs_new_ale_py
def test_a_folder_of_everything(own: Path, shipped: Path) -> None:
    report = roms.import_from(shipped)
    assert report.imported == {game: own / f"{game}.bin" for game in games}
    assert report.present == {}
    assert [Path(sentence.split(" ")[0]).suffix for sentence in report.rejected if "__pycache__" not in sentence] == [
        ".py",
        ".json",
    ]
    assert sorted(file.name for file in own.iterdir()) == sorted(f"{game}.bin" for game in games)
    for game in games:
        assert (own / f"{game}.bin").read_bytes() == (shipped / f"{game}.bin").read_bytes()
        assert roms.find(game) == own / f"{game}.bin"
    again = roms.import_from(shipped)
    assert again.imported == {}
    assert again.present == report.imported
    assert again.rejected == report.rejected


def test_names_and_depth_do_not_matter(own: Path, tmp_path: Path, pong: bytes, breakout: bytes) -> None:
    deep = tmp_path / "a" / "b" / "c"
    deep.mkdir(parents=True)
    (deep / "Video Olympics.A26").write_bytes(pong)
    (tmp_path / "a" / "asterix.bin").write_bytes(gzip.compress(breakout))
    (tmp_path / "a" / "twice").write_bytes(breakout)
    (tmp_path / "a" / "bad").write_bytes(pong[:-1])
    report = roms.import_from(str(tmp_path / "a"))
    assert report.imported == {"breakout": own / "breakout.bin", "pong": own / "pong.bin"}
    assert report.present == {}
    assert report.rejected == (f"{tmp_path / 'a' / 'bad'} is Pong cut short: only the first 2,047 of 2,048 bytes",)
    assert (own / "breakout.bin").read_bytes() == breakout


def test_the_order_is_that_of_the_names(tmp_path: Path) -> None:
    names = [f"{letter}{name}" for letter in "qbzfa" for name in ("/y", "/x")]
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    expected = tuple(f"{tmp_path / name} is empty" for name in sorted(names))
    assert roms.import_from(tmp_path).rejected == expected


def test_a_single_file(own: Path, tmp_path: Path, pong: bytes) -> None:
    (tmp_path / "p").write_bytes(pong)
    assert roms.import_from(tmp_path / "p").imported == {"pong": own / "pong.bin"}


def _zip(file: Path, members: dict[str, bytes]) -> None:
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)


def test_zip_archives(own: Path, tmp_path: Path, pong: bytes, breakout: bytes) -> None:
    source = tmp_path / "zips"
    source.mkdir()
    members = {"folder/": b"", "folder/b.bin.gz": gzip.compress(breakout), "read me": b"hello"}
    _zip(source / "one.zip", members)
    _zip(source / "two.dat", {"p.rom": pong})
    report = roms.import_from(source / "one.zip")
    assert report.imported == {"breakout": own / "breakout.bin"}
    assert report.rejected == (f"'read me' in {source / 'one.zip'} is unknown: its 5 bytes are near to no known game",)
    report = roms.import_from(source)
    assert report.imported == {"pong": own / "pong.bin"}
    assert report.present == {"breakout": own / "breakout.bin"}


def test_names_in_an_archive_decide_nothing(own: Path, tmp_path: Path, pong: bytes, breakout: bytes) -> None:
    names = ["../../../escaped.bin", "/absolute.bin", "..\\up", "a/../../b", "\\\\host\\a"]
    _zip(tmp_path / "evil.zip", {**dict.fromkeys(names, pong), "asterix.bin": breakout})
    before = set(tmp_path.iterdir())
    report = roms.import_from(tmp_path / "evil.zip")
    assert report.imported == {"breakout": own / "breakout.bin"}
    assert report.rejected == tuple(
        f"{name!r} in {tmp_path / 'evil.zip'} has a name that leads out of the archive, or none; unpack it yourself"
        for name in names
    )
    assert list(own.iterdir()) == [own / "breakout.bin"]
    assert set(tmp_path.iterdir()) - before == {own.parent}


def test_a_bad_member_never_stops_the_others(own: Path, tmp_path: Path, pong: bytes, breakout: bytes) -> None:
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("X", pong)
        archive.writestr("bz2", pong, zipfile.ZIP_BZIP2)
        archive.writestr("lzma", pong, zipfile.ZIP_LZMA)
        archive.writestr("NUL\0", pong)
        archive.writestr("b", breakout)
    data = (tmp_path / "a.zip").read_bytes()
    central = data.index(b"PK\x01\x02") + 46  # the name of the first member in the directory
    data = data[: central - 18] + bytes(2) + data[central - 16 : central] + b"" + data[central + 1 :]
    end = data.index(b"PK\x05\x06")  # the directory has become a byte shorter
    (size,) = struct.unpack_from("<I", data, end + 12)
    data = data[: end + 12] + struct.pack("<I", size - 1) + data[end + 16 :]
    (tmp_path / "a.zip").write_bytes(data)
    assert zipfile.ZipFile(tmp_path / "a.zip").namelist()[0] == ""
    report = roms.import_from(tmp_path)
    assert set(report.imported) == {"breakout", "pong"}
    assert [sentence.partition(".zip ")[2].partition(";")[0] for sentence in report.rejected] == [
        "has a name that leads out of the archive, or none",
        "is packed in another way than by Deflate",
        "is packed in another way than by Deflate",
    ]


def test_the_work_of_an_import_is_bounded(tmp_path: Path, breakout: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """12 MB of unknown files took hours: each was searched for every known ROM. Counted in bytes, not in seconds."""
    monkeypatch.setattr("atari.roms.archives._UNPACKED", 10 << 20)
    monkeypatch.setattr("atari.roms.importing._COMPARED", 1 << 20)
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        file.writestr("breakout", breakout)
        for number in range(40):
            file.writestr(f"{number}", number.to_bytes(2, "big") + bytes(500_000))
    compared, unpacked = [0], [0]

    def compare(image: bytes, known: object) -> None:
        compared[0] += len(image)

    def unpack(name: str, data: bytes) -> bytes:
        unpacked[0] += 2 * len(data)
        return data

    monkeypatch.setattr("atari.roms.identification._piece", compare)
    monkeypatch.setattr("atari.roms.archives.unpack", unpack)
    report = roms.import_from(tmp_path / "a.zip")
    assert set(report.imported) == {"breakout"}
    assert len(report.rejected) == 40
    assert 500_000 <= compared[0] <= 1 << 20
    allowed = (10 << 20) + 32 * (tmp_path / "a.zip").stat().st_size
    assert allowed - 1_000_000 <= unpacked[0] <= allowed + 1_000_000
    assert "is unknown: its 500,002 bytes are no known game; `atari roms identify` compares them" in report.rejected[5]
    assert report.rejected[-1].endswith("was not unpacked, because the archives become too large; unpack it yourself")


def test_gzip_of_many_members_is_refused(tmp_path: Path, pong: bytes) -> None:
    (tmp_path / "many.gz").write_bytes(gzip.compress(b"") * 20_000 + gzip.compress(pong))
    (tmp_path / "padded.gz").write_bytes(gzip.compress(pong) + bytes(100))
    report = roms.import_from(tmp_path)
    assert set(report.imported) == {"pong"}
    assert report.rejected == (
        f"{tmp_path / 'many.gz'} is a damaged gzip file (there is more after its end); get it again",
    )


def test_bombs_are_not_unpacked(own: Path, tmp_path: Path, pong: bytes) -> None:
    _zip(tmp_path / "bomb.zip", {"big": bytes(25 * 10**6), "gz": gzip.compress(bytes(25 * 10**6)), "p": pong})
    tracemalloc.start()
    report = roms.import_from(tmp_path / "bomb.zip")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6
    assert report.imported == {"pong": own / "pong.bin"}
    assert [sentence.partition(" has ")[2] for sentence in report.rejected] == [
        "more than 524,288 bytes, which no cartridge has, so it is no ROM file"
    ] * 2


def test_an_archive_with_wrong_sizes(tmp_path: Path) -> None:
    _zip(tmp_path / "a.zip", {"big": bytes(10**6)})
    data = (tmp_path / "a.zip").read_bytes()
    (tmp_path / "a.zip").write_bytes(data.replace(struct.pack("<L", 10**6), struct.pack("<L", 2048)))
    report = roms.import_from(tmp_path / "a.zip")
    assert report.imported == {}
    assert len(report.rejected) == 1


def test_damaged_archives_are_reported(own: Path, tmp_path: Path, pong: bytes) -> None:
    source = tmp_path / "source"
    source.mkdir()
    (source / "p").write_bytes(pong)
    _zip(source / "good.zip", {"p": pong})
    good = (source / "good.zip").read_bytes()
    (source / "cut.zip").write_bytes(good[:-30])
    (source / "flip.zip").write_bytes(good[:200] + bytes([good[200] ^ 255]) + good[201:])
    locked = bytearray(good)  # bit 0 of the flags, in the local and the central header: encrypted
    locked[6] |= 1
    locked[good.index(b"PK\x01\x02") + 8] |= 1
    (source / "locked.zip").write_bytes(locked)
    central = bytearray(good)
    central[good.index(b"PK\x01\x02")] ^= 1
    (source / "central.zip").write_bytes(central)
    report = roms.import_from(source)
    assert report.imported == {"pong": own / "pong.bin"}
    assert [
        (Path(sentence.split(".zip")[0]).name, sentence.split(".zip ")[1][:20]) for sentence in report.rejected
    ] == [
        ("central", "is a damaged zip arc"),
        ("cut", "is a damaged zip arc"),
        ("flip", "cannot be unpacked ("),
        ("locked", "cannot be unpacked ("),
    ]


def test_an_archive_damaged_anywhere_raises_nothing(
    tmp_path: Path, pong: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atari.roms.importing.known_images", dict)  # what is damaged is compared with no game
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.writestr("p", pong)
    data = (tmp_path / "a.zip").read_bytes()
    content = range(31, 31 + len(pong))  # after the header of the only member; the directory follows
    for index in range(len(data)):
        if index in content and index % 100:
            continue
        damaged = bytearray(data)
        damaged[index] ^= 0xFF
        (tmp_path / "a.zip").write_bytes(damaged)
        report = roms.import_from(tmp_path / "a.zip")
        assert bool(report.imported or report.present) != bool(report.rejected), index
        assert index not in content or report.rejected


def test_other_files_are_reported_and_skipped(own: Path, tmp_path: Path, pong: bytes, unreadable: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    os.mkfifo(source / "a pipe")
    (source / "broken.gz").write_bytes(b"\x1f\x8b\x08")
    (source / "dangling").symlink_to(source / "nowhere")
    with (source / "large").open("wb") as file:
        file.truncate(10**12)
    unreadable.rename(source / "z")
    (source / "loop").symlink_to(source)
    (source / "pong").write_bytes(pong)
    report = roms.import_from(source)
    assert report.imported == {"pong": own / "pong.bin"}
    assert [sentence.removeprefix(f"{source}/")[:30] for sentence in report.rejected] == [
        "a pipe is a device or a pipe; ",
        "broken.gz is a damaged gzip fi",
        "there is no file " + f"{source}/dangling"[:13],
        "large has more than 524,288 by",
        "z is no game: its 1 bytes are ",
    ]


def test_an_unreadable_subfolder_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "source" / "closed").mkdir(parents=True)
    really_scan = os.scandir

    def scan(folder: str) -> object:
        if os.fspath(folder).endswith("closed"):
            raise PermissionError(13, "Permission denied", os.fspath(folder))
        return really_scan(folder)

    monkeypatch.setattr(os, "scandir", scan)
    report = roms.import_from(tmp_path / "source")
    assert report.imported == {}
    assert report.rejected == (f"[Errno 13] Permission denied: '{tmp_path / 'source' / 'closed'}'",)


def test_no_file_is_replaced(own: Path, shipped: Path, pong: bytes) -> None:
    own.mkdir(parents=True)
    (own / "pong.bin").write_bytes(pong[:100])
    second = own / f"pong-{games['pong'].rom.md5[:8]}.bin"
    assert roms.import_from(shipped / "pong.bin").imported == {"pong": second}
    assert (own / "pong.bin").read_bytes() == pong[:100]
    assert second.read_bytes() == pong
    assert roms.find("pong") == second
    assert roms.import_from(shipped / "pong.bin").present == {"pong": second}
    second.write_bytes(b"mine")
    with pytest.raises(FileExistsError, match=r"pong-.*\.bin exists and is not Pong; rename it"):
        roms.import_from(shipped / "pong.bin")
    assert second.read_bytes() == b"mine"


def test_a_folder_of_the_usual_name(own: Path, shipped: Path) -> None:
    (own / "pong.bin").mkdir(parents=True)
    assert roms.find("pong", roms.import_from(shipped / "pong.bin").imported["pong"]).parent == own


def test_a_file_system_without_hard_links(
    own: Path, shipped: Path, pong: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(self: Path, other: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(Path, "hardlink_to", fail)
    assert roms.import_from(shipped / "pong.bin").imported == {"pong": own / "pong.bin"}
    assert [(file.name, file.read_bytes()) for file in own.iterdir()] == [("pong.bin", pong)]


def test_a_failed_write_leaves_what_was_there(own: Path, shipped: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own.mkdir(parents=True)
    (own / "pong.bin").write_bytes(b"old")

    def fail(self: Path, other: object) -> None:
        with self.open("wb") as file:
            file.write(b"half")
        raise OSError(28, "No space left on device", str(self))

    monkeypatch.setattr(Path, "write_bytes", fail)
    with pytest.raises(OSError, match="No space left on device"):
        roms.import_from(shipped / "pong.bin")
    assert [(file.name, (own / file.name).stat().st_size) for file in own.iterdir()] == [("pong.bin", 3)]


def test_the_own_folder_can_be_imported_from(own: Path, shipped: Path) -> None:
    own.mkdir(parents=True)
    shutil.copy(shipped / "pong.bin", own / "Pong (1977).a26")
    assert roms.import_from(own).imported == {"pong": own / "pong.bin"}


def test_a_source_that_cannot_be_read_raises(tmp_path: Path, unreadable: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"there is no file .*nothing; check the path"):
        roms.import_from(tmp_path / "nothing")
    with pytest.raises(PermissionError, match=r"locked\.bin may not be read"):
        roms.import_from(unreadable)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ValueError, match="is a device or a pipe"):
        roms.import_from(tmp_path / "pipe")
