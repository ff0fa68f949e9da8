"""Huge and strange folders: the search and the import end, read no file that could block, and say what they left out."""

import io
import os
from pathlib import Path
from typing import Any

import pytest

from atari import roms
from atari.cli import main
from atari.roms import image, importing, locations


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of `ATARI_ROMS` with Breakout under another name."""
    content = roms.find("breakout").read_bytes()
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "own"))
    monkeypatch.setenv("ATARI_ROMS", str(tmp_path / "roms"))
    (tmp_path / "roms").mkdir()
    (tmp_path / "roms" / "z").write_bytes(content)
    return tmp_path / "roms"


def test_an_empty_file_is_not_opened(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The files of /proc have no size, and reading /proc/kmsg waits for the kernel."""
    (folder / "kmsg").touch()
    really_read = image.read_start

    def read(file: Path) -> bytes:
        assert file.name != "kmsg", "it was opened"
        return really_read(file)

    for module in (image, importing):
        monkeypatch.setattr(module, "read_start", read)
    assert roms.installed()["breakout"] == folder / "z"
    assert roms.import_from(folder).rejected == (f"{folder / 'kmsg'} is empty",)


def test_a_named_file_that_has_nothing_yet_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Waiting(io.RawIOBase):
        def read(self, size: int = -1) -> Any:
            return None

    def opened(file: Any, mode: str, opener: Any) -> Waiting:
        os.close(opener(file, os.O_RDONLY))
        return Waiting()

    (tmp_path / "kmsg").touch()
    monkeypatch.setattr(image, "open", opened, raising=False)
    with pytest.raises(ValueError, match="kmsg has no content yet"):
        roms.identify(tmp_path / "kmsg")


def test_each_folder_is_listed_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    listed = []
    really_list = locations._entries
    monkeypatch.setattr(locations, "_entries", lambda folder: listed.append(folder) or really_list(folder))
    roms.installed()
    assert listed.count(folder) == 1


def test_a_folder_with_too_many_files(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in "abc":
        (folder / name).write_text(name)
    monkeypatch.setattr(locations, "MOST_FILES", 3)  # ale-py's folder has more, too
    monkeypatch.setattr(importing, "_MOST_FILES", 3)
    assert roms.installed().get("breakout") != folder / "z"
    assert main(["roms", "list"]) == 0
    assert capsys.readouterr().err.startswith(f"atari: warning: only the first 3 files of {folder}, ")
    report = roms.import_from(folder)
    assert (
        report.rejected[-1]
        == f"{folder} has more than 3 files, and the rest was not read; import a folder of ROM files"
    )
    assert not report.imported


def test_an_import_leaves_out_file_systems_without_a_disk(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "sys").mkdir()
    (folder / "sys" / "a").write_text("a")
    monkeypatch.setattr(importing, "_is_virtual", lambda path: path == str(folder / "sys"))
    report = roms.import_from(folder)
    assert report.rejected == (f"{folder / 'sys'} has files that the system makes up, and was not read",)
    assert "breakout" in report.imported


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no /proc")
def test_proc_has_no_disk_and_a_folder_has(tmp_path: Path) -> None:
    assert importing._is_virtual("/proc")
    assert not importing._is_virtual(str(tmp_path))
    assert not importing._is_virtual(str(tmp_path / "nothing"))
