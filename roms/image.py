"""The bytes of a ROM file: read with a limit, and unpacked if they are gzip-compressed.

This module reads all files that users name, so that a folder, a pipe, a huge file or a gzip bomb raises an exception.
"""

import hashlib
import zlib
from pathlib import Path

from atari.validation import check_file

LIMIT = 512 * 1024
"""The greatest number of bytes of an image. The largest known cartridge has 64 KiB; ale-py reads up to this limit."""

_GZIP_MAGIC = b"\x1f\x8b"
_ZIP_MAGICS = (b"PK\x03\x04", b"PK\x05\x06")


def read_image(file: Path) -> bytes:
    """The cartridge image in `file`, unpacked.

    Raises:
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.
        ValueError: the file is no regular file, is larger than `LIMIT`, is damaged gzip, or a zip archive.
    """
    check_file(file, "give the ROM file in it, or set ATARI_ROMS to the folder")
    try:
        with file.open("rb") as stream:
            data = stream.read(LIMIT + 1)
    except PermissionError:
        raise PermissionError(f"{file} may not be read; give yourself the permission, or another file") from None
    return unpack(str(file), data)


def unpack(name: str, data: bytes) -> bytes:
    """`data`, decompressed if it is gzip; errors contain `name`.

    Raises:
        ValueError: the data has more than `LIMIT` bytes, before or after, is damaged gzip, or a zip archive.
    """
    if data.startswith(_ZIP_MAGICS):
        raise ValueError(f"{name} is a zip archive, not a ROM file; `atari roms import` unpacks it, if it is sound")
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
