"""Fixtures: a user's folder in a temporary directory, and the ROM files in ale-py's wheel."""

import os
from pathlib import Path
from typing import Any

import ale_py
import pytest

from atari.roms.identification import known_images


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's own folder of ROM files, which does not exist yet; and no `ATARI_ROMS`."""
    monkeypatch.delenv("ATARI_ROMS", raising=False)
    monkeypatch.setattr("platformdirs.user_data_path", lambda *names, **options: tmp_path / "data")
    return tmp_path / "data" / "roms"


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """An ale-py without ROM files."""
    monkeypatch.setattr("atari.roms.locations._ale_py_folders", lambda: ())


@pytest.fixture
def collection(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in `ATARI_ROMS`."""
    folder = tmp_path / "collection"
    folder.mkdir()
    monkeypatch.setenv("ATARI_ROMS", str(folder))
    return folder


@pytest.fixture(scope="session")
def shipped() -> Path:
    """The folder of ROM files in ale-py's wheel."""
    return Path(ale_py.__file__).parent / "roms"


@pytest.fixture(scope="session")
def known() -> dict[str, bytes]:
    """The images of all games."""
    return known_images()


@pytest.fixture(scope="session")
def pong(shipped: Path) -> bytes:
    return (shipped / "pong.bin").read_bytes()


@pytest.fixture(scope="session")
def breakout(shipped: Path) -> bytes:
    return (shipped / "breakout.bin").read_bytes()


@pytest.fixture
def unreadable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that cannot be opened, also if the tests run as root, which may open every file."""
    file = tmp_path / "locked.bin"
    file.write_bytes(b"?")
    really_open, really_os_open, really_access = Path.open, os.open, os.access

    def open_unless_locked(self: Path, *arguments: Any, **options: Any) -> Any:
        if self == file:
            raise PermissionError(13, "Permission denied", str(self))
        return really_open(self, *arguments, **options)

    def os_open_unless_locked(path: Any, *arguments: Any, **options: Any) -> int:
        if isinstance(path, Path | str) and Path(path) == file:
            raise PermissionError(13, "Permission denied", str(path))
        return really_os_open(path, *arguments, **options)

    monkeypatch.setattr(Path, "open", open_unless_locked)
    monkeypatch.setattr(os, "open", os_open_unless_locked)
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != file and really_access(path, mode))
    return file
