"""Copies ROM files from a folder, archive or file into your own folder, under their usual names.

Collections are nested folders of files with long names, or of zip archives with one file each. Every file is read,
identified by its content, and written under the game's id. Names in an archive never decide the path of a file.
"""

import os
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from atari.roms.identification import by_content, describe, known_images
from atari.roms.image import LIMIT, read_image, unpack
from atari.roms.locations import store, stored
from atari.validation import check_file

_MOST_MEMBERS = 20_000

# The bytes that an import may unpack from all archives together: a constant, plus a multiple of an archive's bytes.
# Collections of ROM files are packed to about a third.
_UNPACKED, _UNPACKED_PER_BYTE = 64 << 20, 32

# Unknown files are compared with all known games until their sizes add up to this. A comparison also has a fixed cost.
_COMPARED, _COMPARED_PER_FILE = 4 << 20, 16 << 10

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # other methods unpack 4 KB to gigabytes before a limit can act

_Read = Callable[[], bytes]


@dataclass(frozen=True)
class ImportReport:
    """The result of `import_from`, which documents the fields."""

    imported: dict[str, Path]
    present: dict[str, Path]
    rejected: tuple[str, ...]


def import_from(source: str | os.PathLike[str]) -> ImportReport:
    """Copy the known ROM files in a folder (and its subfolders), a zip archive or a single file to your own folder.

    Zip archives in a folder are opened too, and gzip is unpacked. No file in your folder is replaced: a ROM whose usual
    name is taken gets the start of its MD5 in its name. A file that cannot be read, and a member that is damaged,
    encrypted or has a name that no file could have, is rejected with a message, and the others are imported. The time
    is bounded by the size of `source`.

    Returns:
        An object with the files `imported`, and the files `present` before, by game id; and `rejected`, a sentence for
        each file that is not the ROM of a known game.

    Raises:
        FileNotFoundError, PermissionError: `source` cannot be read.
        ValueError: `source` is a device or a pipe.
        OSError: your own folder cannot be written to.

    Example:
        >>> import atari.roms
        >>> report = atari.roms.import_from(atari.roms.find("breakout"))
        >>> "breakout" in {**report.imported, **report.present}
        True
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
    comparable = _COMPARED
    for name, read in _Files(source):
        try:
            image = read()
        except (OSError, ValueError) as error:
            rejected.append(str(error))
            continue
        game = by_content(image)
        if game is None:
            comparable -= len(image) + _COMPARED_PER_FILE
            rejected.append(f"{name} {describe(image, known if comparable > 0 else None)[1]}")
        elif game.id not in imported and game.id not in present:
            if file := stored(game):
                present[game.id] = file
            else:
                imported[game.id] = store(game, image)
    return ImportReport(imported, present, tuple(rejected))


class _Files:
    """The files in `source`. Each has its name and a function that reads it, or raises OSError or ValueError."""

    def __init__(self, source: Path) -> None:
        self._source = source
        self._unpackable = _UNPACKED  # bytes that may still be unpacked

    def __iter__(self) -> Iterator[tuple[str, _Read]]:
        if not self._source.is_dir():
            yield from self._in_file(self._source)
            return
        closed: list[OSError] = []
        for folder, subfolders, names in os.walk(self._source, onerror=closed.append):
            subfolders.sort()
            for name in sorted(names):
                yield from self._in_file(Path(folder, name))
        for error in closed:
            yield str(error.filename), partial(_fail, error)

    def _in_file(self, file: Path) -> Iterator[tuple[str, _Read]]:
        # This order of checks matters, because opening a pipe could block for ever.
        if os.path.isfile(file) and zipfile.is_zipfile(file):
            yield from self._in_zip(file)
        else:
            yield str(file), partial(read_image, file)

    def _in_zip(self, file: Path) -> Iterator[tuple[str, _Read]]:
        try:
            archive = zipfile.ZipFile(file)
        except Exception as error:  # damaged archives raise errors of many classes
            yield str(file), partial(_fail, ValueError(f"{file} is a damaged zip archive ({error}); get it again"))
            return
        with archive:
            members = [info for info in archive.infolist() if not info.filename.endswith("/")]
            if len(members) > _MOST_MEMBERS:
                fault = f"{file} has {len(members):,} files in it; take at most {_MOST_MEMBERS:,} at a time"
                yield str(file), partial(_fail, ValueError(fault))
                return
            self._unpackable += _UNPACKED_PER_BYTE * file.stat().st_size
            for info in members:
                name = f"{info.filename!r} in {file}"
                yield name, partial(self._read_member, name, archive, info)

    def _read_member(self, name: str, archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> bytes:
        if not _names_a_file(info.filename):
            raise ValueError(f"{name} has a name that leads out of the archive, or none; unpack it yourself")
        if info.compress_type not in _METHODS:
            raise ValueError(f"{name} is packed in another way than by Deflate; unpack it yourself")
        if self._unpackable <= 0:
            raise ValueError(f"{name} was not unpacked, because the archives become too large; unpack it yourself")
        self._unpackable -= min(info.file_size, LIMIT)
        try:
            with archive.open(info) as stream:
                data = stream.read(LIMIT + 1)
        except Exception as error:  # any error of the decompressor, or encryption
            raise ValueError(f"{name} cannot be unpacked ({error}); unpack it yourself, or get it again") from None
        try:
            image = unpack(name, data)
        except ValueError:
            self._unpackable -= LIMIT  # gzip may have produced them
            raise
        self._unpackable -= len(image)
        return image


def _names_a_file(name: str) -> bool:
    """Whether a member's name is a valid name of a file in a folder."""
    return bool(name) and not name.startswith(("/", "\\")) and ".." not in re.split(r"[/\\]", name)


def _fail(error: Exception) -> bytes:
    raise error
