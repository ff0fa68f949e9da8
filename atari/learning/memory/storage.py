"""The bytes of a `ReplayMemory`: in memory, or in a file that is mapped into memory.

A file begins with a page of 8192 bytes: a magic number, the options as JSON, and their CRC. The block of the extension
module follows (`atari/emulator/memory/geometry.hpp`).
"""

import json
import mmap
import os
import struct
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from atari.learning.memory.options import MemoryOptions

Block = npt.NDArray[np.uint8]

_PAGE = 8192
_MAGIC = b"atari-replay-1" + (b"<" if sys.byteorder == "little" else b">") + b"\n"
_START = struct.Struct("<16sII")  # magic, length of the JSON, CRC of what follows


def allocate(options: MemoryOptions) -> Block:
    """A block of zeros in memory. The system provides its pages when they are first written.

    Raises:
        MemoryError: the machine has less memory available than the block may take.
    """
    size = options.geometry().block_bytes
    available = _available()
    if size > available:
        raise MemoryError(
            f"this replay memory needs {_gigabytes(size)} GB and {_gigabytes(available)} GB are available; "
            "lower capacity, or compress=True, or give a path for a file"
        )
    flags = {"flags": mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS} if hasattr(mmap, "MAP_ANONYMOUS") else {}
    try:
        memory = mmap.mmap(-1, size, **flags)
    except (OSError, ValueError, OverflowError) as error:
        raise MemoryError(f"this replay memory needs {_gigabytes(size)} GB: {error}") from None
    if hasattr(mmap, "MADV_HUGEPAGE"):
        with suppress(OSError):
            memory.madvise(mmap.MADV_HUGEPAGE)
    return np.frombuffer(memory, np.uint8)


class BlockFile:
    """A file that is mapped into memory, and locked against other processes.

    Attributes:
        options: the options of the memory in the file.
        block: the bytes after the first page.
    """

    def __init__(self, file: BinaryIO, options: MemoryOptions) -> None:
        self.options = options
        self._file, self._process = file, os.getpid()
        size = _PAGE + options.geometry().block_bytes
        self._map = mmap.mmap(file.fileno(), size)
        self.block: Block = np.frombuffer(self._map, np.uint8, offset=_PAGE)

    @classmethod
    def create(cls, path: Path, options: MemoryOptions) -> "BlockFile":
        """Make a file, with all its space on the disk.

        Raises:
            FileExistsError: the file exists.
            OSError: the disk has too little space.
        """
        size = _PAGE + options.geometry().block_bytes
        file = open(path, "x+b", buffering=0)  # noqa: SIM115, kept open
        try:
            _lock(file, path)
            _reserve(file, size, path)
            file.write(_first_page(options))
            return cls(file, options)
        except BaseException:
            file.close()
            path.unlink(missing_ok=True)
            raise

    @classmethod
    def open(cls, path: Path) -> "BlockFile":
        """Map a file that `create` made.

        Raises:
            FileNotFoundError: the file does not exist.
            BlockingIOError: it is open, here or in another process.
            ValueError: the file holds no replay memory, or is damaged.
            OSError: the file has holes, and the disk has no space for them.
        """
        file = open(path, "r+b", buffering=0)  # noqa: SIM115, kept open
        try:
            _lock(file, path)
            options = _read_first_page(file, path)
            size = _PAGE + options.geometry().block_bytes
            found = os.fstat(file.fileno()).st_size
            if found != size:
                raise ValueError(f"{path} has {found} bytes and should have {size}: it was cut, or added to")
            _reserve(file, size, path)
            return cls(file, options)
        except BaseException:
            file.close()
            raise

    def sync(self) -> None:
        """Wait until all bytes are on the disk."""
        self._map.flush()

    def close(self) -> None:
        """Unlock the file. Arrays of its memory stay readable."""
        if not self._file.closed and self._process == os.getpid():
            _unlock(self._file)
        self._file.close()

    def __del__(self) -> None:
        self.close()


def copy_of(options: MemoryOptions, block: Block) -> dict[str, Any]:
    """Options and block as a dict that can be pickled."""
    return {"options": asdict(options), "block": block.copy()}


def options_of(values: Any) -> MemoryOptions:
    """The options at the beginning of a file or a state.

    Raises:
        ValueError: an option is missing, unknown, or wrong.
    """
    try:
        return MemoryOptions.check(**values)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"the options of the replay memory are damaged, or of another version: {error}") from None


def _first_page(options: MemoryOptions) -> bytes:
    text = json.dumps(asdict(options)).encode()
    rest = text.ljust(_PAGE - _START.size, b"\0")
    if len(rest) > _PAGE - _START.size:
        raise ValueError("the names of the parts of the observation are too long for a file")
    return _START.pack(_MAGIC, len(text), zlib.crc32(rest)) + rest


def _read_first_page(file: BinaryIO, path: Path) -> MemoryOptions:
    page = file.read(_PAGE)
    if len(page) < _PAGE or not page.startswith(_MAGIC[:-3]):
        raise ValueError(f"{path} is no replay memory, or its beginning is damaged")
    magic, length, check = _START.unpack_from(page)
    if magic != _MAGIC:
        raise ValueError(f"{path} is of another version of atari-envs, or of a machine with another byte order")
    rest = page[_START.size :]
    if zlib.crc32(rest) != check or length > len(rest):
        raise ValueError(f"{path} is damaged in its first {_PAGE} bytes")
    with naming(path):
        return options_of(json.loads(rest[:length]))


@contextmanager
def naming(what: Path | str) -> Iterator[None]:
    """Begin the message of a ValueError with the name of the file or state."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from None


def _reserve(file: BinaryIO, size: int, path: Path) -> None:
    """Reserve space on the disk: a write to mapped memory without space on the disk would end the process."""
    try:
        if hasattr(os, "posix_fallocate"):
            os.posix_fallocate(file.fileno(), 0, size)
        elif os.fstat(file.fileno()).st_size < size:
            zeros = bytes(1 << 20)
            for start in range(0, size, len(zeros)):
                file.write(zeros[: size - start])
            file.seek(0)
    except OSError as error:
        raise OSError(error.errno, f"{path} needs {_gigabytes(size)} GB on the disk: {error.strerror}") from None


def _lock(file: BinaryIO, path: Path) -> None:
    """Lock the file until it is closed."""
    try:
        import fcntl
    except ImportError:
        return  # Windows does not delete or replace an open file, and locks regions only.
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise BlockingIOError(error.errno, f"{path} is in use by another replay memory; close that one") from None


def _unlock(file: BinaryIO) -> None:
    """Unlock a mapped file before it is closed, because its mapping holds the lock too."""
    with suppress(ImportError, OSError):
        import fcntl

        fcntl.flock(file.fileno(), fcntl.LOCK_UN)


def _gigabytes(size: int) -> str:
    return f"{size / 1e9:.3g}"


def _available() -> int:
    """Bytes of memory that the system reports as available to this process."""
    limits = [2**62]
    with suppress(OSError, ValueError, IndexError):
        lines = Path("/proc/meminfo").read_text().splitlines()
        limits += [int(line.split()[1]) * 1024 for line in lines if line.startswith("MemAvailable")]
    with suppress(OSError, ValueError):
        limit = Path("/sys/fs/cgroup/memory.max").read_text()
        limits.append(int(limit) - int(Path("/sys/fs/cgroup/memory.current").read_text()))
    if len(limits) == 1:
        with suppress(OSError, ValueError, AttributeError):
            limits.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(limits)
