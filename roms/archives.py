"""The files in zip and tar archives, and in archives inside them, unpacked in memory and within bounds.

Collections of ROM files are archives of files, or of archives with one file each. Nothing is written to the disk, so
that names, links and devices in an archive have no effect.
"""

import gzip
import io
import re
import tarfile
import zipfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import IO, Any

from atari.base.archives import METHODS
from atari.roms.image import IMPORTABLE, LIMIT, archive_kind, unpack

_MOST_MEMBERS = 20_000
_DEEPEST = 3
"""The most archives inside each other."""

# The bytes that an import may unpack from all archives together: a constant, plus a multiple of an archive's bytes.
# Collections of ROM files are packed to about a third.
_UNPACKED, _UNPACKED_PER_BYTE = 64 << 20, 32

# The most bytes of an archive inside another: it is packed already, so the outer archive makes it little smaller. A
# larger one may be made of a few bytes, repeated, and a directory of a zip archive takes much more memory than bytes.
_INNER, _INNER_PER_BYTE = 1 << 20, 4

Found = tuple[str, bytes | OSError | ValueError]
"""The name of a file for messages, and its image, or the fault of the file."""

_Member = tuple[str, str, Callable[[], IO[bytes]]]
"""The name of a member, its fault or "", and a function that opens it."""


class _TooLarge(Exception):
    """The bound of unpacked bytes is reached."""


class Unpacker:
    """Unpacks the archives of one import, which share the bound of unpacked bytes."""

    def __init__(self) -> None:
        self._unpackable = _UNPACKED
        self._members = _MOST_MEMBERS
        self._inner = 0

    def files(self, file: Path, kind: str) -> Iterator[Found]:
        """The files in an archive of a kind of `IMPORTABLE`. Each has to be used before the next."""
        size = file.stat().st_size
        self._unpackable += _UNPACKED_PER_BYTE * size
        self._members = _MOST_MEMBERS
        self._inner = _INNER + _INNER_PER_BYTE * size
        with file.open("rb") as stream:
            yield from self._in_archive(str(file), stream, kind, 1)

    def _in_archive(self, name: str, stream: IO[bytes], kind: str, depth: int) -> Iterator[Found]:
        members = _in_zip(stream) if kind == "zip" else self._in_tar(stream, kind)
        try:
            for member, fault, opened in members:
                self._members -= 1
                if self._members < 0:
                    many = f"{_MOST_MEMBERS:,} files in it, and the rest was not read; unpack it yourself"
                    yield name, ValueError(f"{name} has more than {many}")
                    return
                leads_out = member.startswith(("/", "\\")) or ".." in re.split(r"[/\\]", member)
                name_fault = "has a name that leads out of the archive, or none" if leads_out or not member else ""
                yield from self._in_member(f"{member!r} in {name}", name_fault or fault, opened, depth)
        except _TooLarge:
            yield name, ValueError(f"{name} was not unpacked to its end, because it is too large; unpack it yourself")
        except Exception as error:  # damaged archives raise errors of many classes
            yield name, ValueError(f"{name} is a damaged {kind} archive ({error}); get it again")

    def _in_tar(self, stream: IO[bytes], kind: str) -> Iterator[_Member]:
        plain: Any = gzip.GzipFile(fileobj=stream) if kind == "tar.gz" else stream
        bounded: Any = _Bounded(plain, self._pay)  # tarfile calls `read` only
        # The mode "r|" reads forwards only, so that no header makes it go back, and loop for ever.
        with tarfile.open(fileobj=bounded, mode="r|") as archive:
            for info in archive:
                if not info.isdir():
                    fault = "" if info.isreg() and not info.issparse() else "is a link or a device, not a file"
                    opened: Any = partial(archive.extractfile, info)  # a regular file has content
                    yield info.name, fault, opened

    def _pay(self, count: int) -> None:
        """Subtract bytes that were unpacked from those that may be."""
        self._unpackable -= count
        if self._unpackable < 0:
            raise _TooLarge

    def _in_member(self, name: str, fault: str, opened: Callable[[], IO[bytes]], depth: int) -> Iterator[Found]:
        """The file of a member, or the files in it if it is an archive."""
        if self._unpackable <= 0:
            fault = "was not unpacked, because the archives become too large"
        if fault:
            yield name, ValueError(f"{name} {fault}; unpack it yourself")
            return
        try:
            data = self._read(opened)
        except _TooLarge:
            raise
        except Exception as error:  # any error of the decompressor, or encryption
            yield name, ValueError(f"{name} cannot be unpacked ({error}); unpack it yourself, or get it again")
            return
        kind = archive_kind(data)
        if kind not in IMPORTABLE:
            yield name, self._image(name, data)
        elif depth == _DEEPEST or len(data) > self._inner:
            fault = f"inside {depth} others" if depth == _DEEPEST else f"of more than {self._inner:,} bytes"
            yield name, ValueError(f"{name} is an archive {fault}; unpack it yourself")
        else:
            yield from self._in_archive(name, io.BytesIO(data), kind, depth + 1)

    def _read(self, opened: Callable[[], IO[bytes]]) -> bytes:
        """The bytes of a member: one more than a cartridge or an inner archive may have, if it is larger."""
        with opened() as stream:
            data = stream.read(LIMIT + 1)
            if len(data) > LIMIT and archive_kind(data) in IMPORTABLE:
                data += stream.read(self._inner - LIMIT)
        self._unpackable -= len(data)
        return data

    def _image(self, name: str, data: bytes) -> bytes | ValueError:
        try:
            image = unpack(name, data)
        except ValueError as error:
            self._unpackable -= LIMIT  # gzip may have produced them
            return error
        self._unpackable -= len(image)
        return image


class _Bounded:
    """The bytes of a stream, which are paid for as they are read."""

    def __init__(self, stream: IO[bytes], pay: Callable[[int], None]) -> None:
        self._stream = stream
        self._pay = pay

    def read(self, size: int) -> bytes:
        data = self._stream.read(size)
        self._pay(len(data))
        return data


def _in_zip(stream: IO[bytes]) -> Iterator[_Member]:
    with zipfile.ZipFile(stream) as archive:
        for info in archive.infolist():
            if not info.filename.endswith("/"):
                fault = "" if info.compress_type in METHODS else "is packed in another way than by Deflate"
                yield info.filename, fault, partial(archive.open, info)
