"""The folders that are searched for ROM files, and the lookup of a file in them by its content.

A file of the usual name is tried first, so that the common case opens one file. Otherwise the folder's files are
hashed; a hash is cached until the file's size or modification time changes.
"""

import os
import stat
import uuid
from collections.abc import Iterator, Sequence
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from itertools import islice
from pathlib import Path

from atari.base import durable
from atari.base.extras import pip_install
from atari.base.variables import value
from atari.games.catalog import games
from atari.games.game import Game
from atari.roms.image import LIMIT, md5, read_image

MOST_FILES = 20_000
"""The most files of a folder that are read in the search for an unusually named ROM: all known dumps are fewer."""


def path() -> Path:
    """Your own folder of ROM files, which `import_from` and `install` fill; it need not exist yet."""
    from platformdirs import user_data_path  # imported here, because `import atari` looks for no ROM

    return (user_data_path("atari-envs", appauthor=False) / "roms").absolute()


def folders() -> tuple[Path, ...]:
    """The folders to search, in order: the folders in `ATARI_ROMS`, your own, ale-py's. Some may not exist."""
    named = [entry for entry in value("ATARI_ROMS").split(os.pathsep) if entry]
    return (*(Path(os.path.expanduser(entry)).absolute() for entry in named), path(), *_ale_py_folders())


def _ale_py_folders() -> Iterator[Path]:
    package = find_spec("ale_py")
    for place in (package and package.submodule_search_locations) or ():
        yield Path(place, "roms")


def without_ale_py() -> str:
    """A clause for the case that ale-py, whose wheel has the ROM files of the games, is missing; else ""."""
    return "" if find_spec("ale_py") else f"the files that come with ale-py are missing: {pip_install('ale-py')}"


def lookup_each(wanted: Sequence[Game]) -> list[Path | None]:
    """The first file in `folders()` with the ROM of each game, or None. Each folder is read once for all of them."""
    found: list[Path | None] = [None] * len(wanted)
    for folder in folders():
        missing: dict[str, list[int]] = {}
        for index, game in enumerate(wanted):
            if found[index] is None:
                found[index] = next((file for file in usual_files(folder, game) if holds(file, game)), None)
            if found[index] is None and game.rom.md5:
                missing.setdefault(game.rom.md5, []).append(index)
        for file, hash_ in _images_in(folder) if missing else ():
            if hash_ in missing and holds(file, wanted[missing[hash_][0]]):
                for index in missing.pop(hash_):
                    found[index] = file
                if not missing:
                    break
    return found


def usual_files(folder: Path, game: Game) -> tuple[Path, Path]:
    """The paths in `folder` with the usual names of `game`."""
    return folder / f"{game.id}.bin", folder / f"{game.id}.bin.gz"


def holds(file: Path, game: Game) -> bool:
    """Whether `file` can be read and is the ROM of `game`."""
    try:
        return md5(read_image(file)) == game.rom.md5
    except (OSError, ValueError):
        return False


def _images_in(folder: Path) -> Iterator[tuple[Path, str]]:
    """The first `MOST_FILES` files directly in `folder`, by name, that can be images, with the MD5 of each image."""
    for entry in islice(_entries(folder), MOST_FILES):
        try:
            facts = entry.stat()
            # An empty file is no image, and the files of the kernel, of which some block their reader, have no size.
            if 0 < facts.st_size <= LIMIT and stat.S_ISREG(facts.st_mode):
                yield Path(entry.path), _md5_of(entry.path, facts.st_mtime_ns, facts.st_size)
        except (OSError, ValueError):
            continue


def _entries(folder: Path) -> list["os.DirEntry[str]"]:
    """The entries of `folder` by name, hidden ones left out: one may be another process's temporary file."""
    try:
        with os.scandir(folder) as entries:
            return sorted((entry for entry in entries if not entry.name.startswith(".")), key=lambda entry: entry.path)
    except OSError:
        return []


def unread() -> str:
    """A clause about the folders of which files are not read, because they have too many; "" if there is none."""
    names = ", ".join(str(folder) for folder in folders() if len(_entries(folder)) > MOST_FILES)
    return f"only the first {MOST_FILES:,} files of {names} are read; name a folder of ROM files" if names else ""


@lru_cache(maxsize=MOST_FILES)
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
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{target.stem}.{uuid.uuid4().hex}")
    try:
        with durable.naming(target):
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
