"""The first bytes of this package's binary files. A ROM has no such mark, so its name alone does not tell it apart."""

import os
from pathlib import Path

REPLAY = b"ATARIRPL"
SNAPSHOT = b"ATARISNP"


def begins_with(path: str | os.PathLike[str], magic: bytes) -> bool:
    """Whether there is a regular file at `path` that begins with `magic`."""
    try:
        if not Path(path).is_file():  # to open a pipe could block
            return False
        with open(path, "rb") as file:
            return file.read(len(magic)) == magic
    except (OSError, ValueError):
        return False
