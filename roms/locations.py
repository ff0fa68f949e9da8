"""The folders that are searched for ROM files, and the lookup of a file in them by its content.

A file of the usual name is tried first, so that the common case opens one file. Otherwise the folder's files are
hashed; a hash is cached until the file's size or modification time changes.
"""

import os
import uuid
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from itertools import chain
from pathlib import Path

from platformdirs import user_data_path

from atari.games.catalog import games
from atari.games.game import Game
from atari.roms.image import LIMIT, md5, read_image


def path() -> Path:
    """Your own folder of ROM files, which `import_from` and `install` fill; it need not exist yet."""
    return (user_data_path("atari-envs", appauthor=False) / "roms").absolute()


def folders() -> tuple[Path, ...]:
    """The folders to search, in order: the folders in `ATARI_ROMS`, your own, ale-py's. Some may not exist."""
    named = [entry for entry in os.environ.get("ATARI_ROMS", "").split(os.pathsep) if entry]
    return (*(Path(os.path.expanduser(entry)).absolute() for entry in named), path(), *_ale_py_folders())


def _ale_py_folders() -> Iterator[Path]:
    package = find_spec("ale_py")
    for place in (package and package.submodule_search_locations) or ():
        yield Path(place, "roms")


def lookup(game: Game) -> Path | None:
    """The first file in `folders()` with the ROM of this game, or None."""
    for folder in folders():
        for file in chain(usual_files(folder, game), _files_with(folder, game.rom.md5)):
            if holds(file, game):
                return file
    return None


def usual_files(folder: Path, game: Game) -> tuple[Path, Path]:
    """The paths in `folder` with the usual names of `game`."""
    return folder / f"{game.id}.bin", folder / f"{game.id}.bin.gz"


def holds(file: Path, game: Game) -> bool:
    """Whether `file` can be read and is the ROM of `game`."""
    try:
        return md5(read_image(file)) == game.rom.md5
    except (OSError, ValueError):
        return False


def _files_with(folder: Path, wanted: str) -> Iterator[Path]:
    """The files directly in `folder`, hidden ones left out, whose image has this MD5, in the order of their names."""
    try:
        with os.scandir(folder) as entries:
            # A hidden file may be another process's temporary file.
            files = sorted((entry.path, entry) for entry in entries if not entry.name.startswith("."))
    except OSError:
        return
    for name, entry in files:
        try:
            facts = entry.stat()
            if facts.st_size <= LIMIT and _md5_of(name, facts.st_mtime_ns, facts.st_size) == wanted:
                yield Path(name)
        except (OSError, ValueError):
            continue


@lru_cache(maxsize=10_000)
def _md5_of(name: str, mtime_ns: int, size: int) -> str:
    """The MD5 of the image in a file; the other arguments are keys of the cache."""
    return md5(read_image(Path(name)))


def misleads(file: Path, game: Game) -> bool:
    """Whether the name of `file` is the id of another game than its content.

    ale-py uses the rules of the first game, in its own table, that fits the content *or* the name up to its last dot,
    in any case. So Breakout in `asterix.bin` would be scored as Asterix.
    """
    stem = (file.name.rpartition(".")[0] or file.name).lower()
    return stem in games and stem != game.id


def stored(game: Game) -> Path | None:
    """The file in your own folder with a name that `store` gives to this game, and its content; or None."""
    return next((file for file in _own_files(game) if holds(file, game)), None)


def store(game: Game, image: bytes) -> Path:
    """Write `image`, the ROM of `game`, to your own folder and return its path.

    No file is ever replaced: if there is another file of the usual name, the name gets the start of the MD5. The file
    appears complete or not at all, even if several processes store the same game.

    Raises:
        OSError: the folder cannot be made or written to, or has other files of both names.
    """
    for target in _own_files(game):
        with suppress(FileExistsError):
            _create(target, image)
        if holds(target, game):
            return target
    raise FileExistsError(f"{target} exists and is not {game.title}; rename it")


def _own_files(game: Game) -> tuple[Path, Path]:
    return path() / f"{game.id}.bin", path() / f"{game.id}-{game.rom.md5[:8]}.bin"


def _create(target: Path, image: bytes) -> None:
    """Write a new file.

    Raises:
        FileExistsError: the file exists.
        OSError: the file cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{target.stem}.{uuid.uuid4().hex}")
    try:
        part.write_bytes(image)
        try:
            target.hardlink_to(part)  # unlike a rename, this never replaces a file
        except FileExistsError:
            raise
        except OSError:  # a file system without hard links
            target.open("xb").close()
            part.replace(target)
    finally:
        part.unlink(missing_ok=True)
