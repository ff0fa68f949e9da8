"""`atomic_write`: a file that has its old content or all of the new one."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from os import replace
from pathlib import Path
from typing import IO, Any

from atari.base import durable

__all__ = ["atomic_write", "replace"]


@contextmanager
def atomic_write(filepath: str | os.PathLike[str], binary: bool = False, fsync: bool = False) -> Iterator[IO[Any]]:
    """A file to write, which takes the place of `filepath` once the block ends without an exception.

    Args:
        filepath: the file.
        binary: whether it takes bytes rather than text.
        fsync: has no effect; the content is on the disk.

    Example:
        >>> import pathlib, tempfile
        >>> from atari.classic.utils.atomic_write import atomic_write
        >>> path = pathlib.Path(tempfile.mkdtemp(), "results.txt")
        >>> with atomic_write(path) as file:
        ...     _ = file.write("195.0")
        >>> path.read_text()
        '195.0'
    """
    with durable.replacing(Path(filepath)) as part, open(part, "wb" if binary else "w") as file:
        yield file
