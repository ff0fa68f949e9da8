"""Finds the ROM file of a game, for an emulator to load.

ale-py ends the process on an unknown file, so `find` never returns one: each call reads the file and compares its
hash.
"""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from atari.base.magic import REPLAY, begins_with
from atari.games.catalog import games
from atari.games.game import Game
from atari.roms.identification import identify, known_images, recognise
from atari.roms.image import md5, read_image
from atari.roms.locations import (
    folders,
    holds,
    lookup_each,
    misleads,
    path,
    store,
    stored,
    unread,
    usual_files,
    without_ale_py,
)

ENDINGS = (".bin", ".a26")
"""The usual endings of ROM files."""

_registered: dict[Path | None, Path] = {}
"""The ROM of each game file, as `atari.register_game` has registered it."""


def remember(game: Game, rom: str | os.PathLike[str]) -> None:
    """Store this ROM for `find`, for a user's own game, until the process ends."""
    _registered[game.file] = Path(rom).absolute()


def find(game: str | Game, path: str | os.PathLike[str] | None = None) -> Path:
    """The absolute path of a file with the ROM of `game`, checked by its content.

    Args:
        game: id of a game, for example "breakout", or a `Game`. A game of your own without a hash accepts any file.
        path: the file to use; None searches the folders. The ROM of a game of your own may also lie beside its
            definition, with the same name and the suffix .bin or .a26.

    ale-py plays a file that has the name of another game under that game's rules. So such a file is copied to your own
    folder under its right name, and the copy is returned. No file there is replaced.

    Raises:
        TypeError: `game` or `path` is of the wrong kind.
        ValueError: there is no such game, or the file is not its ROM; the message identifies the file.
        FileNotFoundError: there is no file at `path`, or the search found none.
        IsADirectoryError, PermissionError: the file cannot be read, or not be copied if its name misleads.

    Example:
        >>> import atari.roms
        >>> atari.roms.find("breakout").is_file()
        True
    """
    known = games.resolve(game)
    if path is None:
        beside = _registered.get(known.file) or _beside(known)
        if beside is not None:
            return beside
        if not known.rom.md5:
            raise FileNotFoundError(
                f"the game {known.id!r} names no hash to search for; say where its file is with rom=, or put it beside "
                f"the definition, as {known.id}.bin"
            )
        (found,) = lookup_each([known])
        if found is None:
            places = ", ".join(map(str, folders()))
            raise FileNotFoundError(
                f"no ROM file of {known.title} (MD5 {known.rom.md5}) in {places}; "
                f"set ATARI_ROMS to a folder that has it, or run `atari roms import` on that folder"
                + "".join(f"; {clause}" for clause in filter(None, [without_ale_py(), unread()]))
            )
        file = found
    else:
        file = Path(path).absolute()
        image = read_image(file)
        if known.rom.md5 and md5(image) != known.rom.md5:
            fault = recognise(str(file), image, known_images())
            raise ValueError(
                f"the ROM of {known.title} is needed, but {fault}; without a path, the file is searched for"
            )
    is_ours = known.id in games and known.rom.md5 == games[known.id].rom.md5  # a user's own game can have the same id
    return _rightly_named(known, file) if is_ours and misleads(file, known) else file


def installed() -> dict[str, Path]:
    """The file that the search finds for each game, by game id, without games that have none.

    Example:
        >>> import atari.roms
        >>> "breakout" in atari.roms.installed()
        True
    """
    known = [*games.values()]
    return {game.id: file for game, file in zip(known, lookup_each(known), strict=True) if file}


@dataclass(frozen=True)
class Check:
    """The result of `verify` for the ROM of a game; `verify` documents the fields."""

    game: str
    status: Literal["ok", "missing", "wrong"]
    file: Path | None
    md5: str | None
    sha256: str | None
    note: str


def verify(game: str | Game | None = None) -> dict[str, Check]:
    """Check the files that `find` would use for one game or for all games, by game id.

    Returns:
        By game id, an object with `game`, `status`, `file`, `md5`, `sha256` and `note`. `status` is "ok" if `file`,
        which would be used, has the right MD5 and SHA-256; "missing" if no folder has the ROM; "wrong" if only a file
        with the game's name and another content exists. `md5` and `sha256` belong to the unpacked file. `note`
        describes a file with the game's name and another content, which is not used, also with status "ok"; else it
        is empty.

    Raises:
        TypeError, ValueError: `game` is neither the id of a game nor a `Game`.

    Example:
        >>> import atari.roms
        >>> atari.roms.verify("breakout")["breakout"].status
        'ok'
    """
    wanted = [*games.values()] if game is None else [games.resolve(game)]
    return {known.id: _verify(known, file) for known, file in zip(wanted, lookup_each(wanted), strict=True)}


def _verify(game: Game, found: Path | None) -> Check:
    file = _beside(game) or found
    note = _passed_over(game, file)
    if file is None:
        return Check(game.id, "wrong" if note else "missing", None, None, None, note)
    image = read_image(file)
    sha256 = hashlib.sha256(image).hexdigest()
    if game.rom.sha256 in (sha256, *([""] if game.file else [])):  # a user's own game may lack the hash
        return Check(game.id, "ok", file, md5(image), sha256, note)
    note = f"{file} has the MD5 of {game.title} but another SHA-256, so it was forged; remove it"
    return Check(game.id, "wrong", file, md5(image), sha256, note)


def _passed_over(game: Game, used: Path | None) -> str:
    """A sentence about the first file with the game's name and another content, up to the folder of `used`; or ""."""
    for folder in folders():
        for file in usual_files(folder, game):
            if file == used:
                return ""
            if os.path.lexists(file) and not holds(file, game):
                try:
                    return str(identify(file))
                except (OSError, ValueError) as error:
                    return str(error)
        if used and used.parent == folder:
            break
    return ""


def _beside(game: Game) -> Path | None:
    """The ROM beside the definition of a user's own game, or None."""
    if game.file is None:
        return None
    for file in map(game.file.with_suffix, ENDINGS):
        if file.is_file() and (holds(file, game) if game.rom.md5 else not begins_with(file, REPLAY)):
            return file
    return None


def _rightly_named(game: Game, file: Path) -> Path:
    try:
        return stored(game) or store(game, read_image(file))
    except OSError as error:
        raise PermissionError(
            f"{file} is {game.title}, but named as another game, and no copy can be made in {path()} "
            f"({error.strerror or error}); rename it to {game.id}.bin"
        ) from error
