"""`write_page` writes a page into a folder, as a whole or not at all."""

import errno
import os
import re
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from atari.base import durable
from atari.games.game import Game
from atari.web.bundle import ONE_FILE, one_file, site
from atari.web.shelf import Shown, page_files, whole_table

_SHELF, _CORE = "shelf.json", "core.wasm"


def write_page(folder: Path, shown: Sequence[Shown] = (), own_games: Iterable[Game] = ()) -> dict[str, int]:
    """Write a page with the table of all games: a site, and the same page in one file, `atari.html`.

    An earlier page in the folder is replaced, and its replays and ROMs are removed; other files beside it stay. If the
    page cannot be written, the folder is as it was.

    Args:
        folder: the folder, which is made if it is missing.
        shown: the replays, see `page_files`.
        own_games: games of one's own, whose ROMs come with the page.

    Returns:
        The sizes of the written files in bytes, by their names in the folder.

    Raises:
        FileNotFoundError, ValueError: see `page_files`.
        FileExistsError, NotADirectoryError: see `check_folder`.
        OSError: the disk is full, for example.
    """
    check_folder(folder)
    parts = page_files(shown, [*whole_table(), *own_games])
    files = {**site(parts), ONE_FILE: one_file(parts).encode()}
    folder.parent.mkdir(parents=True, exist_ok=True)
    if shutil.disk_usage(folder.parent).free < sum(map(len, files.values())):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder))
    with tempfile.TemporaryDirectory(prefix=f".{folder.name}-", dir=folder.parent) as beside:
        for name, data in files.items():
            path = Path(beside, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            with durable.naming(folder / name):
                path.write_bytes(data)
        for name in _shown_before(folder):
            durable.remove(folder / name)
        for name in files:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            durable.replace(Path(beside, name), folder / name)
    return {name: len(data) for name, data in files.items()}


def check_folder(folder: Path) -> None:
    """Check that a page can be written into a folder: a new one, an empty one, or one with an earlier page.

    Raises:
        NotADirectoryError: it is a file.
        FileExistsError: it has other files, and no page.
    """
    if not folder.exists():
        return
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is a file; a page is written into a folder: name a new one")
    other = next(folder.iterdir(), None)
    if other is not None and not _has_page(folder):
        raise FileExistsError(
            f"{folder} has other files, such as {other.name}, and no page of `atari web`; name a new or an empty folder"
        )


def _has_page(folder: Path) -> bool:
    return (folder / _SHELF).is_file() and (folder / _CORE).is_file()


def _shown_before(folder: Path) -> list[str]:
    """The names of the replays, films and ROMs of an earlier page, as `page_files` gives them."""
    if not _has_page(folder):
        return []
    return re.findall(r'"((?:replays|roms)/[\w-][\w.-]*)"', (folder / _SHELF).read_text(encoding="utf-8"))
