"""The bytes of a ROM file: read with a limit, and unpacked if they are gzip-compressed.

All files that users name are read by this module, so that a folder, a pipe, a huge file or a gzip bomb raises an
exception.
"""

import gzip
import hashlib
import io
import stat
import zlib
from pathlib import Path

LIMIT = 512 * 1024
"""The greatest number of bytes of an image. The largest known cartridge has 64 KiB; ale-py reads up to this limit."""

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
    """Raise the errors of `read_image` if `file` is not a regular file: opening a pipe could block for ever."""
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
    """`data`, decompressed if it is gzip; errors contain `name`.

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
    """The MD5 of an image, as ale-py and the game definitions have it, in hexadecimal digits."""
    return hashlib.md5(image, usedforsecurity=False).hexdigest()
