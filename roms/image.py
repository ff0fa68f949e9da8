"""The bytes of a ROM file: read with a limit, and unpacked if they are gzip-compressed.

Everything that reads a file which a user names goes through here, so that no folder, pipe, huge file or gzip bomb gets
further than an exception.
"""

import gzip
import hashlib
import io
import stat
import zlib
from pathlib import Path

LIMIT = 512 * 1024
"""Bytes that an image may have. The largest cartridge known has 64 KiB; ale-py reads no further than this."""

_GZIP_MAGIC = b"\x1f\x8b"
_ZIP_MAGICS = (b"PK\x03\x04", b"PK\x05\x06")


def read_image(file: Path) -> bytes:
    """The cartridge image in `file`, unpacked.

    Raises:
        FileNotFoundError, IsADirectoryError, PermissionError: it cannot be read.
        ValueError: it is no regular file, is larger than `LIMIT`, is damaged gzip, or a zip archive.
    """
    check_file(file)
    try:
        with file.open("rb") as stream:
            data = stream.read(LIMIT + 1)
    except PermissionError:
        raise PermissionError(f"{file} may not be read; give yourself the permission, or another file") from None
    return unpack(str(file), data)


def check_file(file: Path) -> None:
    """Raise what `read_image` raises if `file` is not a regular file: opening a pipe could wait for ever."""
    try:
        mode = file.stat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        raise FileNotFoundError(f"there is no file {file}; check the path") from None
    except PermissionError:
        raise PermissionError(f"{file} may not be read; check the permissions of its folders") from None
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(f"{file} is a folder; give the ROM file in it, or set ATARI_ROMS to the folder")
    if not stat.S_ISREG(mode):
        raise ValueError(f"{file} is a device or a pipe; give a regular file")


def unpack(name: str, data: bytes) -> bytes:
    """`data`, decompressed if it is gzip; `name` is what an error calls it.

    Raises:
        ValueError: more than `LIMIT` bytes, before or after; damaged gzip; a zip archive.
    """
    if data.startswith(_ZIP_MAGICS):
        raise ValueError(f"{name} is a zip archive, not a ROM file; `atari roms import` unpacks it, if it is sound")
    if data.startswith(_GZIP_MAGIC) and len(data) <= LIMIT:
        try:
            with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
                data = stream.read(LIMIT + 1)
        except (OSError, EOFError, zlib.error) as error:
            raise ValueError(f"{name} is a damaged gzip file ({error}); get it again") from None
    if len(data) > LIMIT:
        raise ValueError(f"{name} has more than {LIMIT:,} bytes, which no cartridge has, so it is no ROM file")
    return data


def md5(image: bytes) -> str:
    """The MD5 by which ale-py and the game files know an image, as hexadecimal digits."""
    return hashlib.md5(image, usedforsecurity=False).hexdigest()
