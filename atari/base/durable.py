"""Files that a kill or a loss of power leaves whole, and that are never written through a symbolic link.

Everything that must survive is written by the operations at the top of this module, each one call of the system: tests
stop trainings before some of them, drawn at random.
"""

import errno
import mmap
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path
from typing import BinaryIO

_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
_PLAIN = os.O_CREAT | getattr(os, "O_BINARY", 0) | _NO_LINK
_NEW = os.O_WRONLY | os.O_EXCL | _PLAIN


def write(file: int, data: bytes | memoryview) -> int:
    """Write to a descriptor; returns the number of bytes."""
    return os.write(file, data)


def sync(file: int) -> None:
    """Wait until a file's bytes are on the disk."""
    os.fsync(file)


def sync_map(data: mmap.mmap) -> None:
    """Wait until all bytes of a mapped file are on the disk."""
    data.flush()


def replace(source: Path, target: Path) -> None:
    """Give a file the name of another one, whose name is lost."""
    os.replace(source, target)


def remove(path: Path) -> None:
    """Remove a name, if it is there."""
    with suppress(FileNotFoundError):
        os.unlink(path)


def truncate(file: int, size: int) -> None:
    """Cut a file."""
    os.ftruncate(file, size)


def sync_folder(folder: Path) -> None:
    """Wait until the names in a folder are on the disk; without effect where a system cannot (Windows)."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def part_of(path: Path) -> Path:
    """The name under which a successor of `path` is written."""
    return path.with_name(path.name + ".part")


def check_target(path: Path) -> None:
    """Check that a file can have this name.

    Raises:
        OSError: a folder, a device or a pipe has it, also through a symbolic link. Root could replace a device.
    """
    if path.exists() and not path.is_file():
        number = errno.EISDIR if path.is_dir() else errno.EINVAL
        raise OSError(number, "it is a folder, a device or a pipe; choose the name of a file", str(path))


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Give an OSError of the block the name of a file, unless it names another file than the successor.

    Libraries name the successor, or no file, and their texts have addresses and times: the text is the system's.
    """
    try:
        yield
    except OSError as error:
        if error.filename not in (None, str(part_of(path)), part_of(path)):
            raise
        number = error.errno or errno.EIO
        raise OSError(number, os.strerror(number) if error.errno else str(error), str(path)) from error


@contextmanager
def _successor(path: Path) -> Iterator[Path]:
    """The name of the successor of `path`, which an error of the block removes. An OSError names `path`."""
    with naming(path):
        try:
            yield part_of(path)
        except BaseException:
            discard(path)
            raise


def discard(path: Path) -> None:
    """Remove the successor of `path`, if there is one and the disk lets it go."""
    with suppress(OSError):
        remove(part_of(path))


def begin(path: Path) -> Path:
    """Make an empty successor of `path` and return its name. `publish` or `discard` ends it.

    Raises:
        OSError: the file cannot be created; `path` is as it was.
    """
    check_target(path)
    with _successor(path) as part:
        remove(part)  # if it is a link, its target does not change
        os.close(os.open(part, _NEW, 0o666))
    return part


def write_part(path: Path, data: bytes, *, lasting: bool = True) -> Path:
    """Write the successor of `path`, and wait until it is on the disk. `publish` gives it its name.

    Args:
        path: the file.
        data: its bytes.
        lasting: False does not wait. A loss of power can then leave an incomplete file, a kill or a full disk cannot.

    Raises:
        OSError: the disk is full, for example; `path` is as it was.
    """
    check_target(path)
    with _successor(path) as part:
        remove(part)
        file = os.open(part, _NEW, 0o666)
        try:
            left = memoryview(data)
            while left:
                left = left[write(file, left) :]
            if lasting:
                sync(file)
        finally:
            os.close(file)
        if lasting:
            sync_folder(path.parent)
    return part


def publish(path: Path, *, lasting: bool = True) -> None:
    """Replace `path` by its successor, and wait until that is on the disk, see `write_part`.

    Raises:
        OSError: the name cannot be given; `path` is as it was, and the successor is removed.
    """
    with _successor(path) as part:
        replace(part, path)
    if lasting:
        sync_folder(path.parent)


def write_file(path: Path, data: bytes, *, lasting: bool = True) -> None:
    """Replace `path` by a file with `data`, or leave it as it was. See `write_part`.

    Raises:
        OSError: the disk is full, for example; `path` is as it was.
    """
    write_part(path, data, lasting=lasting)
    publish(path, lasting=lasting)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """The name for a file that a library writes; the file replaces `path` when the block ends without an error.

    Raises:
        OSError: the file cannot be written; `path` is as it was.
    """
    begin(path)
    with _successor(path) as part:
        yield part
        file = os.open(part, os.O_RDWR | _NO_LINK)
        try:
            sync(file)
        finally:
            os.close(file)
    publish(path)


def start_recording(path: Path, beginning: bytes) -> FileIO:
    """Replace `path` by a file with `beginning`, and open it, without a buffer: a kill leaves what was written.

    Raises:
        OSError: the disk is full, for example; `path` is as it was.
    """
    write_file(path, beginning)
    return FileIO(open_to_append(path), "ab")


def append(path: Path, data: bytes) -> None:
    """Add all of `data` to a file, or nothing. After a loss of power a part of the end may be missing.

    Raises:
        OSError: the disk is full, for example, or the file is a symbolic link; the file is unchanged.
    """
    file = open_to_append(path)
    try:
        size = os.fstat(file).st_size
        with naming(path):
            try:
                if write(file, data) != len(data):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            except BaseException:
                truncate(file, size)
                raise
    finally:
        os.close(file)


def open_to_append(path: Path) -> int:
    """The descriptor of a file, new or not, whose writes are added to its end.

    Raises:
        OSError: the file cannot be opened, or is a symbolic link.
    """
    return os.open(path, os.O_WRONLY | os.O_APPEND | _PLAIN, 0o666)


def lock_file(path: Path, in_use: str) -> BinaryIO:
    """Open a file for its lock alone, and make it if it is missing; see `lock`.

    Raises:
        BlockingIOError: see `lock`.
        OSError: the file is a symbolic link, or the folder is read-only.
    """
    file = os.fdopen(os.open(path, os.O_RDWR | _PLAIN, 0o666), "r+b", buffering=0)
    try:
        lock(file, in_use)
    except BaseException:
        file.close()
        raise
    return file


def lock(file: BinaryIO, in_use: str) -> None:
    """Lock an open file until `unlock`, its closing or the end of the process, however it ends.

    Raises:
        BlockingIOError: it is locked already, by this process or another; `in_use` is the message.
    """
    try:
        import fcntl
    except ImportError:
        return _lock_on_windows(file, in_use)
    try:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        raise BlockingIOError(error.errno, in_use) from None


def _lock_on_windows(file: BinaryIO, in_use: str) -> None:
    import msvcrt  # type: ignore[import-not-found,unused-ignore]

    file.seek(2**40)  # a byte after the end: a locked byte can not be read by others
    try:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined,unused-ignore]
    except OSError as error:
        raise BlockingIOError(error.errno, in_use) from None
    finally:
        file.seek(0)


def unlock(file: BinaryIO) -> None:
    """Unlock a file before it is closed: its mapping into memory would hold the lock."""
    with suppress(ImportError, OSError):
        import fcntl

        fcntl.flock(file.fileno(), fcntl.LOCK_UN)
