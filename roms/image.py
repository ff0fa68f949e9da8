"""The bytes of a ROM file: read with a limit, and unpacked if they are gzip-compressed.

This module reads all files that users name, so that a folder, a pipe, a huge file or a gzip bomb raises an exception.
An archive is recognised by its first bytes, and refused with what to do.
"""

import hashlib
import os
import zlib
from contextlib import suppress
from pathlib import Path

from atari.base import magic
from atari.base.validation import check_file

LIMIT = 512 * 1024
"""The greatest number of bytes of an image. The largest known cartridge has 64 KiB; ale-py reads up to this limit."""

_GZIP_MAGIC = b"\x1f\x8b"
_TAR_BLOCK = 512
_START = 64 << 10  # bytes of gzip that are enough to see what is packed

_MAGICS = {
    b"PK\x03\x04": "zip",
    b"PK\x05\x06": "zip",
    b"7z\xbc\xaf\x27\x1c": "7z",
    b"Rar!\x1a\x07": "rar",
    b"\xfd7zXZ\x00": "xz",
    **{b"BZh%d1AY&SY" % level: "bzip2" for level in range(1, 10)},
}

IMPORTABLE = ("zip", "tar", "tar.gz")
"""The kinds of archives that `atari.roms.import_from` opens."""


def read_image(file: Path) -> bytes:
    """The cartridge image in `file`, unpacked.

    Raises:
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.
        ValueError: the file is no regular file, is larger than `LIMIT`, is damaged gzip, or an archive.
    """
    return unpack(str(file), read_start(file))


def read_start(file: Path) -> bytes:
    """The first `LIMIT` + 1 bytes of a regular file, as they are.

    Raises:
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.
        ValueError: the file is no regular file, or is one of the kernel that would block.
    """
    check_file(file, "give the ROM file in it, or set ATARI_ROMS to the folder")
    no_wait = getattr(os, "O_NONBLOCK", 0)
    try:
        with open(file, "rb", opener=lambda path, flags: os.open(path, flags | no_wait)) as stream:
            data: bytes | None = stream.read(LIMIT + 1)
    except PermissionError:
        raise PermissionError(f"{file} may not be read; give yourself the permission, or another file") from None
    if data is None:
        raise ValueError(f"{file} has no content yet, as files of the kernel can; give a regular file")
    return data


def archive_kind(data: bytes) -> str | None:
    """The kind of the archive that begins with these bytes: "zip", "tar", "tar.gz", "7z", ...; None for other data.

    Data packed by xz or bzip2 counts as an archive, because only its unpacked bytes show whether it is one.
    """
    if data.startswith(_GZIP_MAGIC):
        with suppress(zlib.error):
            start = zlib.decompressobj(16 + zlib.MAX_WBITS).decompress(data[:_START], _TAR_BLOCK)
            return "tar.gz" if _is_tar(start) else None
    return next((kind for magic, kind in _MAGICS.items() if data.startswith(magic)), "tar" if _is_tar(data) else None)


def _is_tar(data: bytes) -> bool:
    """Whether the data begins with a header of a tar archive, which has a checksum."""
    import tarfile  # imported here, because `import atari` reads no ROM

    try:
        tarfile.TarInfo.frombuf(data[:_TAR_BLOCK], "utf-8", "surrogateescape")
    except tarfile.HeaderError:
        return False
    return True


def unpack(name: str, data: bytes) -> bytes:
    """`data`, decompressed if it is gzip; errors contain `name`.

    Raises:
        ValueError: the data has more than `LIMIT` bytes, before or after, is damaged gzip, or an archive.
    """
    if kind := archive_kind(data):
        importable = "`atari roms import` takes the ROM files out of it"
        other = "unpack it yourself, for example with `7z x`, and run `atari roms import` on the folder"
        raise ValueError(f"{name} is a {kind} archive, not a ROM file; {importable if kind in IMPORTABLE else other}")
    if data.startswith(magic.REPLAY):
        raise ValueError(f"{name} is a replay, not a ROM file; `atari replay show {name}` has its facts")
    if data.startswith(_GZIP_MAGIC) and len(data) <= LIMIT:
        data = _gunzip(name, data)
    if len(data) > LIMIT:
        raise ValueError(f"{name} has more than {LIMIT:,} bytes, which no cartridge has, so it is no ROM file")
    return data


def _gunzip(name: str, data: bytes) -> bytes:
    """The content of a gzip file with one member, up to `LIMIT` + 1 bytes.

    A file can consist of thousands of empty members, and each costs time, so more than one member is an error.
    """
    unpacker = zlib.decompressobj(16 + zlib.MAX_WBITS)
    try:
        image = unpacker.decompress(data, LIMIT + 1)
    except zlib.error as error:
        raise ValueError(f"{name} is a damaged gzip file ({error}); get it again") from None
    if len(image) <= LIMIT and (not unpacker.eof or unpacker.unused_data.strip(b"\0")):
        fault = "there is more after its end" if unpacker.eof else "it ends too early"
        raise ValueError(f"{name} is a damaged gzip file ({fault}); get it again")
    return image


def md5(image: bytes) -> str:
    """The MD5 of an image in hexadecimal digits, as in ale-py and the game definitions."""
    return hashlib.md5(image, usedforsecurity=False).hexdigest()
