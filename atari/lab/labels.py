"""Labels: the values of named bytes of RAM, compiled once and evaluated by the extension module.

The value of a label is the result of its `transform`. Without one, it is the bits of the byte that are in `mask`, or
the two digits of a byte that is binary-coded decimal. A `weight` multiplies it.
"""

import difflib
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

import atari._emulator as _emulator
from atari.base.validation import check_integer
from atari.cores import ByteArray
from atari.games.game import Game, RamLabel
from atari.games.labels import compile_label

IntArray = npt.NDArray[np.int32]
BoolArray = npt.NDArray[np.bool_]

_MOST_LISTED = 16


def byte_index(place: Any) -> int:
    """The index 0..127 of a place in RAM: an index, or an address 0x80..0xFF.

    Raises:
        TypeError, ValueError: `place` is neither.
    """
    try:
        number = check_integer("place", place, 0, 255)
    except TypeError:
        whole = "; core.ram() and envs.ram() have all bytes" if isinstance(place, slice) else ""
        raise TypeError(f"a place in RAM is an index 0..127 or an address 0x80..0xFF, got {place!r}{whole}") from None
    except ValueError:
        raise ValueError(f"a place in RAM is an index 0..127 or an address 0x80..0xFF, got {place}") from None
    return number & 127


class UnknownLabelError(KeyError):
    """The game has no label of this name."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError itself shows a text in quotation marks


def unknown_label(name: str, games: Sequence[Game]) -> UnknownLabelError:
    """The error for a name that none of these games has."""
    known = list(dict.fromkeys(label for game in games for label in game.ram_labels))
    which = " and ".join(dict.fromkeys(game.id for game in games))
    if not known:
        return UnknownLabelError(
            f"there are no labels of {which}, so no {name!r}; give an index 0..127 or an address 0x80..0xFF"
        )
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    parts = [label for label in known if label.startswith(f"{name}_")]
    hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(known[:_MOST_LISTED])}"
    if len(parts) > 1:
        return UnknownLabelError(f"{which} has no label {name!r}; it has {', '.join(parts)}")
    more = ", ..." if not near and len(known) > _MOST_LISTED else ""
    return UnknownLabelError(f"{which} has no label {name!r}; {hint}{more}")


class Labels:
    """Some labels of a game, in this order. Immutable.

    Args:
        game: the game.
        names: names of its labels; None is all.

    Attributes:
        hiding: the numbers of the labels that are not always visible.

    Raises:
        KeyError: the game has no such label; the message suggests the nearest.
        TypeError: a name is no text.
        ValueError: an expression is too complex; the message has the game and the label.
    """

    def __init__(self, game: Game, names: Iterable[str] | None = None) -> None:
        self.game = game
        self.names = tuple(game.ram_labels if names is None else names)
        for name in self.names:
            if not isinstance(name, str):
                raise TypeError(f"the name of a label is a text, got {name!r}")
            if name not in game.ram_labels:
                raise unknown_label(name, (game,))
        labels = [game.ram_labels[name] for name in self.names]
        self.hiding = tuple(number for number, label in enumerate(labels) if label.visible is not None)
        self._compiled = _emulator.Labels([_compile(game, label) for label in labels])

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies compile the labels again."""
        return Labels, (self.game, self.names)

    def evaluate(self, ram: ByteArray) -> tuple[IntArray, BoolArray]:
        """The values of the labels in copies of RAM, and whether they are visible.

        Args:
            ram: (rows, 128) uint8.

        Returns:
            int32 (labels, rows) and bool (labels, rows). Values that are not visible are 0.

        Raises:
            TypeError, ValueError: `ram` is not such an array.
        """
        rams = np.ascontiguousarray(ram)
        if rams.dtype != np.uint8:
            raise TypeError(f"ram must be uint8 of shape (rows, 128), got {rams.dtype}")
        if rams.ndim != 2 or rams.shape[1] != 128:
            raise ValueError(f"ram must be uint8 of shape (rows, 128), got the shape {rams.shape}")
        values, visible = self._results(len(rams))
        self._compiled.evaluate(rams, values, visible)
        return values, visible

    def values(self, ram: ByteArray) -> dict[str, int | None]:
        """The values of the labels in one RAM, (128,) uint8, by name; None where a label is not visible."""
        numbers, visible = self.evaluate(ram[None])
        shown = zip(self.names, numbers[:, 0].tolist(), visible[:, 0].tolist(), strict=True)
        return {name: number if seen else None for name, number, seen in shown}

    def evaluate_lanes(
        self, engine: _emulator.VectorEngine, lanes: IntArray, of: _emulator.RamOf
    ) -> tuple[IntArray, BoolArray]:
        """As `evaluate`, in the RAM of these lanes of a vector, int32 (rows,), without a copy in Python.

        Raises:
            RuntimeError: lanes are being played.
        """
        values, visible = self._results(len(lanes))
        engine.evaluate_labels(self._compiled, lanes, values, visible, of)
        return values, visible

    def _results(self, rows: int) -> tuple[IntArray, BoolArray]:
        shape = len(self.names), rows
        return np.empty(shape, np.int32), np.empty(shape, np.bool_)

    def byte_of(self, name: str, ram: ByteArray, value: Any) -> int:
        """The byte 0..255 that gives a label a value: the inverse of its transform, found by trying all bytes.

        Bits outside of the label's mask do not change. If several bytes have the value, the result is the byte that
        changes the fewest bits, then the lowest.

        Args:
            name: the name of one of these labels.
            ram: (128,) uint8, the other bytes, which a transform may read.
            value: the integer.

        Raises:
            TypeError: the value is no integer.
            ValueError: no byte has this value; the message names the possible values.
        """
        number = self.names.index(name)
        try:
            wanted = check_integer("value", value, -(2**31), 2**31 - 1)
        except TypeError:
            raise TypeError(f"the value of {name!r} must be an integer, got {value!r}") from None
        except ValueError:
            wanted = None
        byte = -1 if wanted is None else self._compiled.byte_of(number, ram, wanted)
        if byte < 0:
            possible = _listed(self._compiled.possible_values(number, ram))
            raise ValueError(f"{name!r} of {self.game.id} cannot be {value}; possible values are {possible}")
        return byte


@lru_cache(maxsize=4096)
def labels_of(game: Game, name: str | None = None) -> Labels:
    """One label of a game, or all, compiled once."""
    return Labels(game, None if name is None else (name,))


def evaluate_label(name: str, lanes: Mapping[Game, slice | list[int]], rams: ByteArray) -> tuple[IntArray, BoolArray]:
    """The values of a label, (lanes,) each, and whether they are visible, as in the lanes of games that have it.

    Raises:
        KeyError: no game has such a label.
    """
    if not any(name in game.ram_labels for game in lanes):
        raise unknown_label(name, tuple(lanes))
    values, visible = np.zeros(len(rams), np.int32), np.zeros(len(rams), np.bool_)
    for game, rows in lanes.items():
        if name in game.ram_labels:
            found, seen = labels_of(game, name).evaluate(rams[rows])
            values[rows], visible[rows] = found[0], seen[0]
    return values, visible


def _compile(game: Game, label: RamLabel) -> tuple[int, int, bool, list[int], list[int]]:
    parts = compile_label(label)
    try:
        _emulator.Labels([parts])
    except ValueError as error:
        raise ValueError(f"the label {label.name!r} of {game.id} cannot be compiled: {error}") from None
    return parts


def _listed(values: Sequence[int]) -> str:
    """Numbers in words: a range, a range with its step, or a list."""
    steps = {second - first for first, second in pairwise(values)}
    if len(values) > 2 and len(steps) == 1:
        step = steps.pop()
        return f"{values[0]}..{values[-1]}" + (f" in steps of {step}" if step > 1 else "")
    if len(values) > _MOST_LISTED:
        return f"{len(values)} within {values[0]}..{values[-1]}, such as {', '.join(map(str, values[:_MOST_LISTED]))}"
    return ", ".join(map(str, values))
