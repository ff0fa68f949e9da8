"""Identifies the game of a file; for an unknown file, its fault and the most similar game.

ale-py's wheel has the images of the known games, so an unknown file can be compared with each image: it may be a part
of the image, contain it, or differ from it in some bytes.
"""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from atari.games.catalog import games
from atari.games.game import Game
from atari.roms.image import md5, read_image
from atari.roms.locations import lookup_each

# Shorter sequences occur in several games by chance, or are the zeros at the start of many games.
_SHORTEST_PIECE = 64

# Two different games share at most an eighth of their bytes, except Atlantis and its sequel.
_NEAR = 0.3


@dataclass(frozen=True)
class Identification:
    """The identity of a file; `identify` documents the fields. `str()` of it is a sentence."""

    name: str
    size: int
    md5: str
    sha256: str
    game: Game | None
    nearest: Game | None
    verdict: str

    def __str__(self) -> str:
        return f"{self.name} {self.verdict}"


def identify(file: str | os.PathLike[str]) -> Identification:
    """Identify a ROM file by its content.

    Returns:
        An object with the file's `name`, and `size`, `md5` and `sha256` of its image, after unpacking. `game` is the
        game with this ROM, else None; then `nearest` is the most similar game, or None. `verdict` is a sentence without
        its subject, and `str()` of the object the sentence.

    Raises:
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.
        ValueError: it is no regular file, has more bytes than any cartridge (512 KiB), is damaged gzip, or an archive
            (zip, tar, 7z, rar, ...).

    Example:
        >>> import atari.roms
        >>> found = atari.roms.identify(atari.roms.find("breakout"))
        >>> found.game.title, found.size
        ('Breakout', 2048)
    """
    image = read_image(Path(file))
    return recognise(str(file), image, {} if by_content(image) else known_images())


def by_content(image: bytes) -> Game | None:
    """The game whose ROM has exactly these bytes."""
    return _games_by_md5().get(md5(image))


@cache
def _games_by_md5() -> dict[str, Game]:
    return {game.rom.md5: game for game in games.values()}


def known_images() -> dict[str, bytes]:
    """The images of all games with a file in the searched folders, by game id."""
    known = [*games.values()]
    return {game.id: read_image(file) for game, file in zip(known, lookup_each(known), strict=True) if file}


def recognise(name: str, image: bytes, known: Mapping[str, bytes]) -> Identification:
    """Identify an image; an unknown image is compared with the `known` images."""
    game = by_content(image)
    nearest, verdict = (None, f"is {game.title}") if game else describe(image, known)
    digest = hashlib.sha256(image).hexdigest()
    return Identification(name, len(image), md5(image), digest, game, nearest, verdict)


def describe(image: bytes, known: Mapping[str, bytes] | None) -> tuple[Game | None, str]:
    """The most similar game and the verdict for an unknown image, which is not compared if `known` is None."""
    size = f"{len(image):,} bytes"
    if not image:
        return None, "is empty"
    if image.count(image[0]) == len(image):
        return None, f"is no game: its {size} are all {image[0]:#04x}"
    if known is None:
        return None, f"is unknown: its {size} are no known game; `atari roms identify` compares them"
    return (
        _piece(image, known)
        or _overdump(image, known)
        or _similar(image, known)
        or (None, f"is unknown: its {size} are near to no known game")
    )


def _piece(image: bytes, known: Mapping[str, bytes]) -> tuple[Game, str] | None:
    """The verdict if the image is part of the image of a game, or of several."""
    wholes = [game for game, whole in known.items() if len(image) >= _SHORTEST_PIECE and image in whole]
    if not wholes:
        return None
    # Games that begin with the piece come first: files are truncated at the end far more often than at the start.
    wholes.sort(key=lambda game: not known[game].startswith(image))
    whole = known[wholes[0]]
    titles = " or ".join(games[game].title for game in wholes[:3])
    where = "first" if whole.startswith(image) else "last" if whole.endswith(image) else "middle"
    return games[wholes[0]], f"is {titles} cut short: only the {where} {len(image):,} of {len(whole):,} bytes"


def _overdump(image: bytes, known: Mapping[str, bytes]) -> tuple[Game, str] | None:
    """The verdict if the image contains a whole game: repeated, or with bytes before or after it."""
    inside = [game for game, whole in known.items() if whole in image]
    if not inside:
        return None
    nearest = max(inside, key=lambda game: len(known[game]))
    whole, title = known[nearest], games[nearest].title
    times, rest = divmod(len(image), len(whole))
    if not rest and image == whole * times:
        return games[nearest], f"is {title} repeated {times} times: {len(image):,} bytes instead of {len(whole):,}"
    before = image.find(whole)
    after = len(image) - len(whole) - before
    extra = " and ".join(f"{n:,} bytes {side}" for n, side in ((before, "before"), (after, "after")) if n)
    return games[nearest], f"is {title} with {extra} it that do not belong to it"


def _similar(image: bytes, known: Mapping[str, bytes]) -> tuple[Game, str] | None:
    """The game with the largest share of equal bytes, if the share is too large for a coincidence."""
    equal = {game: _equal_bytes(image, whole) for game, whole in known.items()}
    shares = {game: equal[game] / max(len(image), len(whole)) for game, whole in known.items()}
    best = max(shares, key=shares.__getitem__, default=None)
    if best is None or shares[best] < _NEAR:
        return None
    nearest, size, same = games[best], len(known[best]), equal[best]
    if len(image) == size:
        fault = f"{size - same:,} of {size:,} bytes differ"
    else:
        fault = f"{same:,} of its {size:,} bytes are here, in a file of {len(image):,}"
    return nearest, f"is unknown, and nearest to {nearest.title}: {fault}"


def _equal_bytes(one: bytes, other: bytes) -> int:
    """The number of equal bytes with both images aligned at their starts or at their ends, whichever is more."""
    shorter, longer = sorted((np.frombuffer(one, np.uint8), np.frombuffer(other, np.uint8)), key=len)
    n = len(shorter)
    return int(max(np.count_nonzero(shorter == longer[:n]), np.count_nonzero(shorter == longer[-n:])))
