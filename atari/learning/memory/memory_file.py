"""The bytes of a `ReplayMemory`: in memory, or in a file that is mapped into memory.

A file begins with a page of 8192 bytes: a magic number, the options as JSON, and their CRC. The block of the extension
module follows (`atari/emulator/memory/geometry.hpp`).
"""

import errno
import json
import mmap
import os
import re
import struct
import sys
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any, BinaryIO, get_type_hints

import numpy as np
import numpy.typing as npt

from atari.base import durable, json_text
from atari.base.typed_table import check_table
from atari.base.validation import check_file
from atari.learning.memory.options import MemoryOptions

Block = npt.NDArray[np.uint8]

_PAGE = 8192
_ORDER = b"<" if sys.byteorder == "little" else b">"
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
        path: the absolute path.
        options: the options of the memory in the file.
        block: the bytes after the first page.
    """

    def __init__(self, file: BinaryIO, path: Path, options: MemoryOptions) -> None:
        self.path, self.options = path.absolute(), options
        self._file, self._process = file, os.getpid()
        self._size = _PAGE + options.geometry().block_bytes
        self._map = mmap.mmap(file.fileno(), self._size)
        self.block: Block = np.frombuffer(self._map, np.uint8, offset=_PAGE)

    @classmethod
    def create(cls, path: Path, options: MemoryOptions) -> "BlockFile":
        """Make a file, with all its space on the disk.

        Raises:
            FileExistsError: the file exists.
            OSError: the disk has too little space.
        """
        page = _first_page(options)
        file = open(path, "x+b", buffering=0)  # noqa: SIM115, kept open
        try:
            _lock(file, path)
            _reserve(file, _PAGE + options.geometry().block_bytes, path)
            durable.write(file.fileno(), page)
            durable.sync(file.fileno())
            made = cls(file, path, options)
            made.sync_name()
            return made
        except BaseException:
            file.close()
            durable.remove(path)
            raise

    @classmethod
    def open(cls, path: Path) -> "BlockFile":
        """Map a file that `create` made.

        Raises:
            FileNotFoundError, IsADirectoryError: the file does not exist, or is a folder.
            BlockingIOError: it is open, here or in another process.
            ValueError: the file is a symbolic link, a pipe or a device; it holds no replay memory, or is damaged.
            OSError: the file has holes, and the disk has no space for them.
        """
        if path.is_symlink():
            raise ValueError(f"{path} is a symbolic link, through which nothing is written; give the path of the file")
        file = open(check_file(path), "r+b", buffering=0)  # noqa: SIM115, kept open
        try:
            _lock(file, path)
            options = _read_first_page(file, path)
            size = _PAGE + options.geometry().block_bytes
            found = os.fstat(file.fileno()).st_size
            if found != size:
                raise ValueError(f"{path} has {found} bytes and should have {size}: it was cut, or added to")
            _reserve(file, size, path)
            return cls(file, path, options)
        except BaseException:
            file.close()
            raise

    def check_size(self) -> None:
        """Check that no other program has cut the file: access to a mapped page beyond its end ends the process.

        Raises:
            OSError: the file is shorter than it was.
        """
        found = os.fstat(self._file.fileno()).st_size
        if found < self._size:
            raise OSError(
                errno.EIO,
                f"{self.path} was cut to {found} of {self._size} bytes while it was open: what it held is lost; "
                "close this memory",
            )

    def sync(self) -> None:
        """Wait until all bytes are on the disk."""
        durable.sync_map(self._map)

    def successor(self) -> "BlockFile":
        """A new file beside this one, for `replace`."""
        part = durable.part_of(self.path)
        durable.remove(part)
        return BlockFile.create(part, self.options)

    def replace(self, old: "BlockFile") -> None:
        """Take the name of another file. A kill leaves one of them under this name; `sync_name` decides which.

        Raises:
            OSError: the name could not be given.
        """
        self.sync()
        durable.replace(self.path, old.path)
        self.path = old.path

    def sync_name(self) -> None:
        """Wait until the file's name is on the disk."""
        durable.sync_folder(self.path.parent)

    def discard(self) -> None:
        """Close and remove the file."""
        self.close()
        durable.remove(self.path)

    def close(self) -> None:
        """Unlock the file. Arrays of its memory stay readable."""
        if not self._file.closed and self._process == os.getpid():
            durable.unlock(self._file)
        self._file.close()

    def __del__(self) -> None:
        if hasattr(self, "_file"):
            self.close()


def state_of(options: MemoryOptions, block: Block) -> dict[str, Any]:
    """A memory as a dict that can be pickled."""
    return {"options": asdict(options), "block": block}


def block_of(state: Any, options: MemoryOptions) -> Block:
    """The block in a result of `state_of`.

    Raises:
        ValueError: it is no such result, or a memory with other options.
    """
    if not isinstance(state, Mapping) or set(state) != {"options", "block"}:
        raise ValueError("it must be a dict of options and block, as state() returns it")
    if checked_options(state["options"]) != options:
        raise ValueError("it is a replay memory with other options")
    block, shape = np.asarray(state["block"]), (options.geometry().block_bytes,)
    if block.dtype != np.uint8 or block.shape != shape:
        raise ValueError(f"its block must be uint8 {shape}, got {block.dtype} {block.shape}")
    return block


def checked_options(values: Any) -> MemoryOptions:
    """The options at the beginning of a file or a state.

    Raises:
        ValueError: an option is missing, unknown, or wrong.
    """
    try:
        check_table(values, "the table of options", get_type_hints(MemoryOptions))
        if not re.fullmatch(r"[<>|=][biuf]\d{1,2}", values["action_dtype"]):
            raise ValueError(f"action_dtype is {values['action_dtype']!r:.60}")
        return MemoryOptions.check(**values)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"the options of the replay memory are damaged, or of another version: {error}") from None


def _magic(options: MemoryOptions) -> bytes:
    """The first bytes of a file. Version 2 has saved states with the greatest priority of each row."""
    return b"atari-replay-%d%s\n" % (1 if options.priority_exponent is None else 2, _ORDER)


def _first_page(options: MemoryOptions) -> bytes:
    text = json.dumps(asdict(options)).encode()
    rest = text.ljust(_PAGE - _START.size, b"\0")
    if len(rest) > _PAGE - _START.size:
        raise ValueError("the names of the parts of the observation are too long for a file")
    return _START.pack(_magic(options), len(text), zlib.crc32(rest)) + rest


def _read_first_page(file: BinaryIO, path: Path) -> MemoryOptions:
    page = file.read(_PAGE)
    if len(page) < _PAGE or not page.startswith(b"atari-replay-"):
        raise ValueError(f"{path} is no replay memory, or its beginning is damaged")
    magic, length, check = _START.unpack_from(page)
    if magic not in (b"atari-replay-1" + _ORDER + b"\n", b"atari-replay-2" + _ORDER + b"\n"):
        raise ValueError(f"{path} is of another version of atari-envs, or of a machine with another byte order")
    rest = page[_START.size :]
    if zlib.crc32(rest) != check or length > len(rest):
        raise ValueError(f"{path} is damaged in its first {_PAGE} bytes")
    with naming(path):
        options = checked_options(json_text.parse(rest[:length], "the table of options"))
    if magic != _magic(options):
        raise ValueError(f"{path} is a memory with priorities of an earlier version of atari-envs; make a new memory")
    return options


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
    """Lock the file until it is closed. `path` must be its name still: a restored memory may have replaced it."""
    in_use = f"{path} is in use by another replay memory; close that one"
    durable.lock(file, in_use)
    if not os.path.samestat(os.fstat(file.fileno()), os.stat(path)):
        raise BlockingIOError(errno.EWOULDBLOCK, in_use)


def _gigabytes(size: int) -> str:
    return f"{size / 1e9:.3g}"


def _available() -> int:
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
