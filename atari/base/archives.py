"""Zip archives of strangers: members are unpacked up to a bound."""

import zipfile
import zlib

METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""The methods of packing that are read: others unpack 4 KB to gigabytes before a limit can act."""


def read_member(archive: zipfile.ZipFile, name: str, most_bytes: int) -> bytes:
    """The unpacked bytes of a member.

    Raises:
        ValueError: there is no such member; it is larger or damaged, or packed by another method than Deflate.
    """
    try:
        info = archive.getinfo(name)
        check_member(info, most_bytes)
        with archive.open(info) as file:
            return file.read()
    except KeyError:
        raise ValueError(f"it has no {name!r}") from None
    except (zipfile.BadZipFile, zlib.error, RuntimeError, OSError, EOFError) as error:
        raise ValueError(f"{name!r} is damaged: {error}") from None


def check_member(info: zipfile.ZipInfo, most_bytes: int) -> None:
    """Refuse a member that is larger when it is unpacked; `zipfile` unpacks no more than the size that was checked.

    Raises:
        ValueError: it is larger, or packed by another method than Deflate.
    """
    if info.file_size > most_bytes:
        raise ValueError(f"{info.filename!r} unpacks to {info.file_size:,} bytes, and {most_bytes:,} are allowed")
    if info.compress_type not in METHODS:
        raise ValueError(f"{info.filename!r} is not packed by Deflate")
