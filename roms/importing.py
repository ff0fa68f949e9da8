"""Copies ROM files from a folder, archive or file into your own folder, under their usual names.

Collections are nested folders of files with long names, or of zip archives with one file each. Every file is read,
identified by its content, and written under the game's id: names in an archive never decide where a file is written.
"""

import os
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from atari.roms.identification import known_images, recognise
from atari.roms.image import LIMIT, check_file, read_image, unpack
from atari.roms.locations import holds, path, store

# With LIMIT, this bounds the time that a malicious archive can cost to some seconds.
_MOST_MEMBERS = 20_000

_Read = Callable[[], bytes]


@dataclass(frozen=True)
class ImportReport:
    """The result of `import_from`.

    `imported` are the files written, `present` those that existed before, by game id. `rejected` has a sentence for
    each file that is not the ROM of a known game.
    """

    imported: dict[str, Path]
    present: dict[str, Path]
    rejected: tuple[str, ...]


def import_from(source: str | os.PathLike[str]) -> ImportReport:
    """Copy the known ROM files in a folder (and its subfolders), a zip archive or a single file to `path()`.

    Zip archives in a folder are opened too, and gzip is unpacked. A file in `path()` that has the name of a game but
    another content is replaced.

    Raises:
        FileNotFoundError, PermissionError: `source` cannot be read.
        OSError: `path()` cannot be written to.
    """
    source = Path(source)
    if not source.is_dir():
        check_file(source)
    if not os.access(source, os.R_OK):
        raise PermissionError(f"{source} may not be read; give yourself the permission, or another source")
    known = known_images()
    imported: dict[str, Path] = {}
    present: dict[str, Path] = {}
    rejected: list[str] = []
    for name, read in _files(source):
        try:
            image = read()
        except (OSError, ValueError) as error:
            rejected.append(str(error))
            continue
        found = recognise(name, image, known)
        if found.game is None:
            rejected.append(str(found))
        elif found.game.id not in imported and found.game.id not in present:
            target = path() / f"{found.game.id}.bin"
            if holds(target, found.game):
                present[found.game.id] = target
            else:
                imported[found.game.id] = store(found.game, image)
    return ImportReport(imported, present, tuple(rejected))


def _files(source: Path) -> Iterator[tuple[str, _Read]]:
    """Each file in `source`, as its name and a function that reads it, or raises OSError or ValueError."""
    if not source.is_dir():
        yield from _in_file(source)
        return
    closed: list[OSError] = []
    for folder, subfolders, names in os.walk(source, onerror=closed.append):
        subfolders.sort()
        for name in sorted(names):
            yield from _in_file(Path(folder, name))
    for error in closed:
        yield str(error.filename), partial(_fail, error)


def _in_file(file: Path) -> Iterator[tuple[str, _Read]]:
    # Checked in this order, because opening a pipe could block for ever.
    if os.path.isfile(file) and zipfile.is_zipfile(file):
        yield from _in_zip(file)
    else:
        yield str(file), partial(read_image, file)


def _in_zip(file: Path) -> Iterator[tuple[str, _Read]]:
    try:
        archive = zipfile.ZipFile(file)
    except Exception as error:  # of many classes, all for a damaged archive
        yield str(file), partial(_fail, ValueError(f"{file} is a damaged zip archive ({error}); get it again"))
        return
    with archive:
        members = [info for info in archive.infolist() if not info.is_dir()]
        if len(members) > _MOST_MEMBERS:
            fault = f"{file} has {len(members):,} files in it; take at most {_MOST_MEMBERS:,} at a time"
            yield str(file), partial(_fail, ValueError(fault))
            return
        for info in members:
            name = f"{info.filename!r} in {file}"
            yield name, partial(_read_member, name, archive, info)


def _read_member(name: str, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
    try:
        with archive.open(info) as stream:
            data = stream.read(LIMIT + 1)
    except Exception as error:  # any error of its decompressor, or encryption
        raise ValueError(f"{name} cannot be unpacked ({error}); unpack it yourself, or get it again") from None
    return unpack(name, data)


def _fail(error: Exception) -> bytes:
    raise error
