"""What a kill, or a loss of power, leaves of a folder, at any durable operation of a training.

`Disk` stands before the operations of `atari.base.durable`. Before each it can make an image of the folder: as a
process that is killed leaves it, or as a loss of power can leave it, when any pages that were written since the last
sync of their file, and any names that changed since the last sync of the folder, are lost.
"""

import errno
import os
import random
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from atari.base import durable

OPERATIONS = ("write", "sync", "sync_map", "replace", "remove", "truncate", "sync_folder")
"""The functions of `atari.base.durable` that change a disk."""

_PAGE = 4096


class Stopped(BaseException):
    """The end of a training whose image was made."""


class Disk:
    """The files in a folder, as they are and as they are certain to be after a loss of power.

    Args:
        folder: the folder of a training, which need not exist yet.
        stop_at: the number of the operation before which `image` is made, from 0; then `Stopped` is raised.
        image: the folder of the image.
        generator: decides what a loss of power loses; None is a kill, which loses nothing.
    """

    def __init__(
        self, folder: Path, stop_at: int, image: Path | None = None, generator: random.Random | None = None
    ) -> None:
        self.folder, self.stop_at, self.image, self.generator = folder, stop_at, image, generator
        self.count = 0
        self.names: list[str] = []
        self.first_config: int | None = None  # the number of operations after which the configuration is certain
        self._files: dict[int, bytes] = {}  # by inode, the bytes on the disk
        self._entries: dict[str, int] = {}  # by name, the inode, on the disk
        self._contents: dict[int, bytes] = {}  # by inode, the newest bytes of files that have lost their name
        if folder.exists():
            self.sync_folder()
            self._files = {inode: (folder / name).read_bytes() for name, inode in self._entries.items()}

    def _now(self) -> dict[str, int]:
        return {path.name: path.stat().st_ino for path in self.folder.iterdir() if path.is_file()}

    def before(self, name: str, arguments: tuple[Any, ...]) -> None:
        """Called before an operation."""
        self.names.append(name)
        if self.count == self.stop_at:
            if self.image is not None:
                self._make_image(self.image)
            raise Stopped
        self.count += 1
        if name in ("replace", "remove"):
            for path in arguments:
                if path.is_file():
                    self._contents[path.stat().st_ino] = path.read_bytes()

    def after(self, name: str, arguments: tuple[Any, ...]) -> None:
        """Called after an operation."""
        if name == "sync":
            status = os.fstat(arguments[0])
            path = next((path for path in self.folder.iterdir() if path.stat().st_ino == status.st_ino), None)
            if path is not None:
                self._files[status.st_ino] = path.read_bytes()
        elif name == "sync_map":
            path = self.folder / "memory.replay"
            path = path if path.exists() else durable.part_of(path)
            self._files[path.stat().st_ino] = path.read_bytes()
        elif name == "sync_folder":
            self.sync_folder()
            if self.first_config is None and "config.json" in self._entries:
                self.first_config = self.count

    def sync_folder(self) -> None:
        """The names are on the disk."""
        self._entries = self._now()

    def _make_image(self, image: Path) -> None:
        shutil.rmtree(image, ignore_errors=True)
        if self.generator is None:
            shutil.copytree(self.folder, image)
            return
        image.mkdir()
        now = self._now()
        for name in sorted(now.keys() | self._entries.keys()):
            old, new = self._entries.get(name), now.get(name)
            inode = old if old == new or self.generator.random() < 0.5 else new
            if inode is not None:
                (image / name).write_bytes(self._torn(inode, now))

    def _torn(self, inode: int, now: dict[str, int]) -> bytes:
        """The bytes of a file, of whose pages since its last sync some are lost."""
        assert self.generator is not None
        kept = self._files.get(inode, b"")
        path = next((self.folder / name for name, other in now.items() if other == inode), None)
        new = self._contents.get(inode, kept) if path is None else path.read_bytes()
        lost = self.generator.choice((0.0, 0.5, 1.0))
        size = len(kept) if self.generator.random() < lost else len(new)
        result = bytearray(new[:size].ljust(size, b"\0"))
        for start in range(0, size, _PAGE):
            if self.generator.random() < lost:
                page = kept[start : min(start + _PAGE, size)]
                result[start : start + _PAGE] = page.ljust(min(_PAGE, size - start), b"\0")
        return bytes(result)


class FullDisk(Disk):
    """A disk without room for some operations."""

    def __init__(self, folder: Path, full: range) -> None:
        super().__init__(folder, -1)
        self.full = full

    def before(self, name: str, arguments: tuple[Any, ...]) -> None:
        super().before(name, arguments)
        if name == "write" and self.count in self.full:
            raise OSError(errno.ENOSPC, "No space left on device")


@contextmanager
def on(disk: Disk) -> Iterator[None]:
    """Put a disk before the operations of `atari.base.durable`."""
    before = {name: getattr(durable, name) for name in OPERATIONS}

    def through(name: str, operation: Callable[..., Any]) -> Callable[..., Any]:
        def called(*arguments: Any) -> Any:
            disk.before(name, arguments)
            result = operation(*arguments)
            disk.after(name, arguments)
            return result

        return called

    for name, operation in before.items():
        setattr(durable, name, through(name, operation))
    try:
        yield
    finally:
        for name, operation in before.items():
            setattr(durable, name, operation)
