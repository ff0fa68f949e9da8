"""`CausalMap`: the effects of each byte of a game's RAM, and its probable meaning. `files.py` stores it."""

import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from atari.task import Task

POSITIONS = ("position_x", "position_y")


@dataclass(frozen=True, eq=False)
class ByteCauses:
    """The effects of one byte of RAM, by the forks in which it was changed.

    `derived`: the game rewrites the byte in each frame before it reads it, so a poke has no effect. `inert`: a change
    stays, and nothing else changes. `rewritten` is the part of the changes that were gone after a frame, and `seen`
    the part that was seen on the screen, 0..1; `frames` are the frames until then, mostly, and 0 if none was seen.
    `reward`, `lives` and `over`: a change causes reward, changes the lives, or ends the game. `writes` are the other
    bytes that differ after a change, the most frequent first. `pixels` is a bool array of the screen, (height, 160):
    the pixels that a change of the byte changed. `box` is the box around most of them, (left, top, width, height), or
    None.
    """

    index: int
    derived: bool
    inert: bool
    rewritten: float
    seen: float
    frames: int
    reward: bool
    lives: bool
    over: bool
    writes: tuple[int, ...]
    box: tuple[int, int, int, int] | None
    pixels: NDArray[np.bool_]


@dataclass(frozen=True)
class Suggestion:
    """The probable meaning of a byte of RAM.

    `index` is the byte, 0..127. `kind` is "position_x", "position_y", "score" or "lives", like the kind of a label in a
    game definition. `transform` is an expression over the byte `v`: the column or row of the left or upper edge of the
    thing that moves, or None. `support` is the number of forks that agree or not, and `share` the part of them that
    agree, 0..1. `width` and `height` are the size of the moving thing, in pixels, and None for the other kinds.
    `weight` is the worth of one unit of a score byte, and `encoding` "bcd" or "plain".
    """

    index: int
    kind: str
    support: int
    share: float
    transform: str | None = None
    width: int | None = None
    height: int | None = None
    weight: int | None = None
    encoding: str | None = None

    def __str__(self) -> str:
        agree = f"({self.share:.0%} of {self.support} forks)"
        place = f"${0x80 + self.index:02X} {self.index}"
        if self.transform is not None:
            return f"{place}: {self.kind[-1]} = {self.transform}, {self.width} x {self.height} pixels {agree}"
        if self.weight is not None:
            return f"{place}: {self.kind}, {self.encoding}, unit {self.weight} {agree}"
        return f"{place}: {self.kind} {agree}"

    def label(self) -> str:
        """The suggestion as a value of the table `[ram]` of a game definition, in TOML."""
        names = ("index", "kind", "encoding", "weight", "transform")
        facts = {name: value for name in names if (value := getattr(self, name)) is not None}
        facts |= {"sources": ["measured"], "evidence": f"causal map: {self.share:.0%} of {self.support} forks"}
        return "{" + ", ".join(f"{name} = {json.dumps(value)}" for name, value in facts.items()) + "}"


@dataclass(frozen=True, eq=False, repr=False)
class CausalMap:
    """The effects of each byte of a game's RAM, as `atari.lab.causes` and `atari.lab.shipped_causes` return them.

    `bytes[i]` is about byte i, `pixel(x, y)` returns the bytes that change a pixel, and `suggestions` are probable
    meanings. `settings` are the arguments of `causes`. The other fields are None in a map from a file: `pixel_counts`
    (128, height, 160) uint16, the number of forks that changed a pixel; `effects`, a row for each fork with an effect,
    with the columns `atari.lab.causal.fit.COLUMNS`; `ram` (states, 128) uint8, the RAM of the states; `screen`
    (height, 160, 3) uint8, the screen of one of them; `task`, the task that was played.
    """

    game: str
    height: int
    settings: Mapping[str, int]
    bytes: tuple[ByteCauses, ...]
    suggestions: tuple[Suggestion, ...]
    pixel_counts: NDArray[np.uint16] | None = None
    effects: NDArray[np.int32] | None = None
    ram: NDArray[np.uint8] | None = None
    screen: NDArray[np.uint8] | None = None
    task: Task | None = None

    def pixel(self, x: int, y: int) -> list[int]:
        """The bytes whose changes changed the pixel in column x, 0..159, and row y.

        The byte with the most such forks comes first; in a map from a file, the byte that changes the fewest pixels.

        Raises:
            IndexError: there is no such pixel.
        """
        if not (0 <= x < 160 and 0 <= y < self.height):
            raise IndexError(f"there is no pixel ({x}, {y}); the screen has 160 columns and {self.height} rows")
        found = [byte.index for byte in self.bytes if byte.pixels[y, x]]
        counts = self.pixel_counts
        if counts is not None:
            return sorted(found, key=lambda index: -int(counts[index, y, x]))
        return sorted(found, key=lambda index: int(self.bytes[index].pixels.sum()))

    def __repr__(self) -> str:
        seen = sum(byte.seen > 0 for byte in self.bytes)
        return f"CausalMap({self.game!r}, {seen} bytes seen on the screen, {len(self.suggestions)} suggestions)"
