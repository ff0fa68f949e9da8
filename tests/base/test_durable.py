"""Files that a kill leaves whole."""

import os
from pathlib import Path

import pytest

from atari.base import durable


def test_a_file_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a"
    durable.write_file(path, b"one")
    durable.write_file(path, b"two")
    assert path.read_bytes() == b"two"
    assert os.listdir(tmp_path) == ["a"]


@pytest.mark.parametrize("operation", ["write", "sync", "replace", "sync_folder"])
def test_a_file_that_cannot_be_written_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, operation: str) -> None:
    path = tmp_path / "a"
    durable.write_file(path, b"one")

    def full(*args: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(durable, operation, full)
    with pytest.raises(OSError, match="No space left"):
        durable.write_file(path, b"two")
    assert path.read_bytes() == b"one"
    assert os.listdir(tmp_path) == ["a"]


def test_half_a_write_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(durable, "write", lambda file, data: os.write(file, data[:2]))
    durable.write_file(tmp_path / "a", b"twelve bytes")
    assert (tmp_path / "a").read_bytes() == b"twelve bytes"
    with pytest.raises(OSError, match="No space left on device"):
        durable.append(tmp_path / "a", b"and")
    assert (tmp_path / "a").read_bytes() == b"twelve bytes"


@pytest.mark.skipif(not hasattr(os, "O_NOFOLLOW"), reason="this system follows links")
def test_no_link_is_followed(tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    victim.write_bytes(b"mine")
    for name in ("a", "a.part", "b", "b.part", "log"):
        (tmp_path / name).symlink_to(victim)
    durable.write_file(tmp_path / "a", b"new")
    with durable.replacing(tmp_path / "b") as part:
        part.write_bytes(b"new")
    with pytest.raises(OSError, match="symbolic links"):
        durable.append(tmp_path / "log", b"row")
    assert victim.read_bytes() == b"mine"
    assert [(tmp_path / name).read_bytes() for name in "ab"] == [b"new", b"new"]
    assert not (tmp_path / "a").is_symlink()


def test_a_library_writes_a_whole_file_or_none(tmp_path: Path) -> None:
    def stopped() -> None:
        with durable.replacing(tmp_path / "a") as part:
            part.write_bytes(b"half")
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        stopped()
    assert not os.listdir(tmp_path)


def test_a_lock_is_held_once(tmp_path: Path) -> None:
    with open(tmp_path / "a", "x+b") as first, open(tmp_path / "a", "r+b") as second:
        durable.lock(first, "in use")
        with pytest.raises(BlockingIOError, match="in use"):
            durable.lock(second, "in use")
        durable.unlock(first)
        durable.lock(second, "in use")
