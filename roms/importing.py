"""Copies ROM files from a folder, archive or file into your own folder, under their usual names.

Collections are nested folders of files with long names, or of archives. Every file is read, identified by its content,
and written under the game's id. Names in an archive never decide the path of a file.
"""

import os
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from atari.base.validation import check_file
from atari.roms.archives import Found, Unpacker
from atari.roms.identification import by_content, describe, known_images
from atari.roms.image import IMPORTABLE, archive_kind, read_start, unpack
from atari.roms.locations import store, stored

# Unknown files are compared with all known games until their sizes add up to this. A comparison also has a fixed cost.
_COMPARED, _COMPARED_PER_FILE = 4 << 20, 16 << 10

_MOST_FILES = 200_000
"""The most files of a folder, with its subfolders, that are read."""


@dataclass(frozen=True)
class ImportReport:
    """The result of `import_from`, which documents the fields."""

    imported: dict[str, Path]
    present: dict[str, Path]
    rejected: tuple[str, ...]


def import_from(source: str | os.PathLike[str]) -> ImportReport:
    """Copy the known ROM files in a folder (and its subfolders), an archive or a single file to your own folder.

    Archives are zip, tar and tar.gz. Archives in a folder are opened too, and archives in an archive, up to the third;
    gzip is unpacked. No file in your folder is replaced: a ROM whose usual name is taken gets the start of its MD5 in
    its name. A file that cannot be read, an archive of another kind such as 7z or rar, and a member that is damaged,
    encrypted, a link or has a name that no file could have, is rejected with a message, and the others are imported.
    The time is bounded by the size of `source`: at most 200,000 files are read, and none of file systems without a
    disk, such as /proc, that are mounted in it.

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
    for name, image in _files(source):
        if isinstance(image, Exception):
            rejected.append(str(image))
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


def _files(source: Path) -> Iterator[Found]:
    unpacker = Unpacker()
    if not source.is_dir():
        yield from _in_file(source, unpacker)
        return
    closed: list[OSError] = []
    read = 0
    for folder, subfolders, names in os.walk(source, onerror=closed.append):
        for virtual in [name for name in subfolders if _is_virtual(os.path.join(folder, name))]:
            subfolders.remove(virtual)
            place = os.path.join(folder, virtual)
            yield place, ValueError(f"{place} has files that the system makes up, and was not read")
        subfolders.sort()
        for name in sorted(names):
            read += 1
            if read > _MOST_FILES:
                many = f"{_MOST_FILES:,} files, and the rest was not read; import a folder of ROM files"
                yield str(source), ValueError(f"{source} has more than {many}")
                return
            yield from _in_file(Path(folder, name), unpacker)
    for error in closed:
        yield str(error.filename), error


def _is_virtual(folder: str) -> bool:
    """Whether a folder is where a file system without a disk is mounted, such as /proc and /sys."""
    try:
        return hasattr(os, "statvfs") and os.path.ismount(folder) and os.statvfs(folder).f_blocks == 0
    except OSError:
        return False


def _in_file(file: Path, unpacker: Unpacker) -> Iterator[Found]:
    try:
        if file.is_file() and not file.stat().st_size:  # some files of the kernel block, and none has a size
            yield str(file), b""
            return
        data = read_start(file)  # first, because opening a pipe could block for ever
        kind = archive_kind(data) or ("zip" if zipfile.is_zipfile(file) else None)
        if kind not in IMPORTABLE:
            yield str(file), unpack(str(file), data)
            return
    except (OSError, ValueError) as error:
        yield str(file), error
        return
    yield from unpacker.files(file, kind)
