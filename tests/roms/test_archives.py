"""Archives of ROM files: archives in archives, tar, bounds, and the kinds that are refused with what to do."""

import gzip
import io
import lzma
import tarfile
import tracemalloc
import zipfile
from bz2 import compress as bzip2
from pathlib import Path

import pytest

from atari import roms
from atari.cli import main


def zipped(members: dict[str, bytes]) -> bytes:
    """A zip archive."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return content.getvalue()


def tarred(members: dict[str, bytes], mode: str = "w", kind: int = tarfile.PAX_FORMAT) -> bytes:
    """A tar archive; `mode` is as in `tarfile.open`."""
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode=mode, format=kind) as archive:  # type: ignore[call-overload]
        for name, data in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))
    return content.getvalue()


def tgz(members: dict[str, bytes]) -> bytes:
    return tarred(members, "w:gz")


def stored(file: Path, content: bytes) -> Path:
    file.write_bytes(content)
    return file


@pytest.mark.parametrize("kind", [tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT])
@pytest.mark.parametrize("mode", ["w", "w:gz"])
def test_tar_archives(own: Path, tmp_path: Path, pong: bytes, breakout: bytes, mode: str, kind: int) -> None:
    long = "/".join(["folder"] * 14)
    members = {f"{long}/Pong.bin": pong, "ROM/b.bin.gz": gzip.compress(breakout), "./read me": b"hello"}
    file = stored(tmp_path / "Roms", tarred(members, mode, kind))
    report = roms.import_from(file)
    assert report.imported == {"breakout": own / "breakout.bin", "pong": own / "pong.bin"}
    assert report.rejected == (f"'./read me' in {file} is unknown: its 5 bytes are near to no known game",)
    assert (own / "pong.bin").read_bytes() == pong


@pytest.mark.parametrize("outer", [zipped, tarred, tgz])
@pytest.mark.parametrize("inner", [zipped, tarred, tgz])
def test_archives_in_archives(own: Path, tmp_path: Path, pong: bytes, breakout: bytes, outer, inner) -> None:  # type: ignore[no-untyped-def]
    content = {"HC ROMS.zip": inner({"Video Olympics.bin": pong, "x": b"no"}), "b": breakout}
    file = stored(tmp_path / "a", outer(content))
    report = roms.import_from(file)
    assert report.imported == {"breakout": own / "breakout.bin", "pong": own / "pong.bin"}
    (sentence,) = report.rejected
    assert sentence == f"'x' in 'HC ROMS.zip' in {file} is unknown: its 2 bytes are near to no known game"


def test_the_third_archive_is_the_last(tmp_path: Path, pong: bytes, breakout: bytes) -> None:
    content = zipped({"p": pong, "4": tgz({"b": breakout})})
    report = roms.import_from(stored(tmp_path / "a", zipped({"2": zipped({"3": content})})))
    assert set(report.imported) == {"pong"}
    (sentence,) = report.rejected
    assert sentence == f"'4' in '3' in '2' in {tmp_path / 'a'} is an archive inside 3 others; unpack it yourself"


def test_members_of_all_inner_archives_are_counted(
    tmp_path: Path, pong: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atari.roms.archives._MOST_MEMBERS", 5)
    inner, many = (
        zipped({"a": b"", "b": b""}),
        "has more than 5 files in it, and the rest was not read; unpack it yourself",
    )
    file = stored(tmp_path / "a", zipped({"1": inner, "2": inner, "p": pong}))
    report = roms.import_from(file)
    assert not report.imported
    assert report.rejected[-2:] == (f"'2' in {file} {many}", f"{file} {many}")
    report = roms.import_from(stored(file, zipped({str(number): b"" for number in range(6)})))
    assert [sentence.partition(str(file))[2] for sentence in report.rejected] == [*[" is empty"] * 5, f" {many}"]


def test_links_and_devices_in_a_tar_archive_have_no_effect(own: Path, tmp_path: Path, pong: bytes) -> None:
    (tmp_path / "secret").write_bytes(pong)
    with tarfile.open(tmp_path / "a.tar", "w") as archive:
        for name, kind, target in (
            ("folder", tarfile.DIRTYPE, ""),
            ("symlink", tarfile.SYMTYPE, str(tmp_path / "secret")),
            ("link", tarfile.LNKTYPE, "symlink"),
            ("device", tarfile.CHRTYPE, ""),
            ("pipe", tarfile.FIFOTYPE, ""),
        ):
            info = tarfile.TarInfo(name)
            info.type, info.linkname = kind, target
            archive.addfile(info)
        for name in ("../up", "/absolute"):
            info = tarfile.TarInfo(name)
            info.size = len(pong)
            archive.addfile(info, io.BytesIO(pong))
    before = set(tmp_path.iterdir())
    report = roms.import_from(tmp_path / "a.tar")
    assert not report.imported
    assert set(tmp_path.iterdir()) == before
    assert [sentence.partition(".tar ")[2] for sentence in report.rejected] == [
        *["is a link or a device, not a file; unpack it yourself"] * 4,
        *["has a name that leads out of the archive, or none; unpack it yourself"] * 2,
    ]


def test_a_sparse_file_is_refused(tmp_path: Path) -> None:
    """It declares gigabytes in a header."""
    info = tarfile.TarInfo("sparse")
    info.pax_headers = {"GNU.sparse.map": "0,0", "GNU.sparse.size": str(2**40), "GNU.sparse.major": "0"}
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w") as archive:
        archive.addfile(info)
    (sentence,) = roms.import_from(stored(tmp_path / "a.tar", content.getvalue())).rejected
    assert "'sparse' in" in sentence
    assert "unpack it yourself" in sentence


BIG = bytes(25 * 10**6)
BOMBS = {
    "zip in zip": lambda: zipped({"inner": zipped({"big": BIG})}),
    "large inner": lambda: zipped({"inner": tarred({"big": BIG})}),
    "tar.gz": lambda: tgz({"big": BIG}),
    "tar.gz in zip": lambda: zipped({"inner": tgz({"big": BIG})}),
    "tar.gz of gz": lambda: tgz({"big": gzip.compress(BIG)}),
}


@pytest.mark.parametrize("kind", BOMBS)
def test_bombs_in_archives_are_not_unpacked(tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atari.roms.archives._UNPACKED", 1 << 23)
    file = stored(tmp_path / "bomb", BOMBS[kind]())
    tracemalloc.start()
    report = roms.import_from(file)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20e6
    assert not report.imported
    assert report.rejected


def test_a_tar_archive_is_unpacked_to_a_bound(tmp_path: Path, pong: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("atari.roms.archives._UNPACKED", 1 << 20)
    file = stored(tmp_path / "a", tgz({"p": pong, "big": bytes(10**7), "b": pong}))
    report = roms.import_from(file)
    assert set(report.imported) == {"pong"}
    assert report.rejected[-1] == f"{file} was not unpacked to its end, because it is too large; unpack it yourself"


@pytest.mark.parametrize("make", [tarred, tgz])
def test_a_tar_archive_damaged_anywhere_raises_nothing(  # type: ignore[no-untyped-def]
    tmp_path: Path, pong: bytes, make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atari.roms.importing.known_images", dict)  # what is damaged is compared with no game
    data = make({"p": pong})
    for index in (*range(0, min(512, len(data)), 31), *range(512, len(data), 707)):
        damaged = bytearray(data)
        damaged[index] ^= 0xFF
        report = roms.import_from(stored(tmp_path / "a", bytes(damaged)))
        assert report.imported or report.present or report.rejected, index
        roms.import_from(stored(tmp_path / "a", data[:index]))


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        ("7z", b"7z\xbc\xaf\x27\x1c\0\4" + bytes(500)),
        ("rar", b"Rar!\x1a\x07\0" + bytes(500)),
        ("rar", b"Rar!\x1a\x07\1\0" + bytes(10**6)),
        ("xz", lzma.compress(b"?" * 5000)),
        ("bzip2", bzip2(b"?" * 5000)),
    ],
)
def test_other_kinds_are_named_with_what_to_do(tmp_path: Path, kind: str, content: bytes, pong: bytes) -> None:
    advice = (
        f"is a {kind} archive, not a ROM file; unpack it yourself, for example with `7z x`, and run "
        "`atari roms import` on the folder"
    )
    file = stored(tmp_path / "a", content)
    assert roms.import_from(file).rejected == (f"{file} {advice}",)
    with pytest.raises(ValueError, match=f"is a {kind} archive, not a ROM file; unpack it yourself"):
        roms.find("pong", file)
    file = stored(tmp_path / "b", zipped({"inner": content, "p": pong}))
    report = roms.import_from(file)
    assert set(report.imported) == {"pong"}
    assert report.rejected == (f"'inner' in {file} {advice}",)


@pytest.mark.parametrize(("kind", "make"), [("zip", zipped), ("tar", tarred), ("tar.gz", tgz)])
def test_identify_names_an_archive(tmp_path: Path, pong: bytes, kind: str, make) -> None:  # type: ignore[no-untyped-def]
    file = stored(tmp_path / "Roms", make({"ROM/pong/pong.bin": pong}))
    with pytest.raises(ValueError, match=f"Roms is a {kind} archive, not a ROM file; `atari roms import` takes the"):
        roms.identify(file)


def test_the_command_imports_what_it_names(tmp_path: Path, pong: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    """It does not advise to run itself."""
    content = {"HC ROMS.zip": zipped({"Video Olympics.bin": pong}), "cut.zip": zipped({"p": pong})[:-30]}
    file = stored(tmp_path / "ROMS.zip", zipped(content))
    assert main(["roms", "import", str(file)]) == 0
    out = capsys.readouterr().out
    assert "games imported: 1 (pong)" in out
    assert f"'cut.zip' in {file} is a damaged zip archive" in out
    assert "`atari roms import`" not in out
