"""Places of a value in RAM: single bytes, and decimal numbers of several bytes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray

IntArray = npt.NDArray[np.int64]

RAM_BYTES = 128

STRIDES = (1, -1, 2, -2)
"""Distances from the byte of the lowest digits of a number to the next."""

UNITS = (1, 10, 100, 1000)
"""The worth of the last digit in RAM: many games draw one or more zeros after it that never change."""

_NONE = RAM_BYTES  # the index of a byte that is always 0
_DIGITS = np.array([10 * (v >> 4) + (v & 15) if v >> 4 < 10 and v & 15 < 10 else -1 for v in range(256)], np.int64)


@dataclass(frozen=True)
class Place:
    """A place of a value. `bytes` are indices 0..127; a decimal number has the byte of its lowest digits first."""

    bytes: tuple[int, ...]
    decimal: bool
    unit: int

    def __str__(self) -> str:
        text = " ".join(f"0x{0x80 + byte:02X}" for byte in reversed(self.bytes))
        return text + (" decimal" if self.decimal else "") + (f" x {self.unit}" if self.unit != 1 else "")


class Places:
    """A set of places whose values are computed together.

    `bytes` is (M, L): the indices of the L bytes of each of M places, `_NONE` where a number has no byte.
    """

    def __init__(self, bytes: IntArray, strides: IntArray, units: IntArray, decimal: bool) -> None:
        self._bytes, self._strides, self._units = bytes, strides, units
        self.decimal = decimal

    @classmethod
    def all_bytes(cls) -> "Places":
        """The 128 bytes."""
        one = np.ones(RAM_BYTES, np.int64)
        return cls(np.arange(RAM_BYTES)[:, None], one, one, decimal=False)

    @classmethod
    def numbers(cls, bytes: Sequence[int] | None = None) -> "Places":
        """All decimal numbers, at first of one byte; or one number in the given bytes, lowest first."""
        units = np.array(UNITS)
        if bytes is not None:
            return cls(np.tile(np.array(bytes), (len(units), 1)), 0 * units, units, decimal=True)
        low, strides, unit = (axis.ravel() for axis in np.meshgrid(np.arange(RAM_BYTES), STRIDES, UNITS, indexing="ij"))
        return cls(low[:, None], strides, unit, decimal=True)

    def __len__(self) -> int:
        return len(self._bytes)

    def columns(self) -> dict[Place, int]:
        """The different places, in the order of their first bytes, each with one of its columns in `values`."""
        rows = zip(self._bytes.tolist(), self._units.tolist(), strict=True)
        places = [Place(tuple(byte for byte in row if byte != _NONE), self.decimal, unit) for row, unit in rows]
        return {place: column for column, place in enumerate(places)}

    def indices(self) -> list[int]:
        """The indices of all their bytes, ascending."""
        return [byte for byte in np.unique(self._bytes).tolist() if byte != _NONE]

    def pick(self, which: npt.NDArray[Any]) -> "Places":
        """The places that a mask (M,) or indices select."""
        return Places(self._bytes[which], self._strides[which], self._units[which], self.decimal)

    def with_byte_of(self, indices: Sequence[int]) -> "Places":
        """The places that have at least one of these bytes."""
        return self.pick(np.asarray(np.isin(self._bytes, indices).any(axis=1)))

    def long_enough(self, number: int) -> "Places":
        """The same numbers with as many bytes as `number` needs; numbers that do not fit into RAM are left out."""
        places = self
        while len(places):
            lengths = (places._bytes != _NONE).sum(1)
            short = (100**lengths * places._units <= number) & (places._strides != 0)
            if not short.any():
                break
            column = np.where(short, places._bytes[:, -1] + places._strides, _NONE)
            fits = ~short | ((column >= 0) & (column < RAM_BYTES))
            bytes = np.concatenate([places._bytes, column[:, None]], axis=1)
            places = Places(bytes, places._strides, places._units, self.decimal).pick(fits)
        return places

    def values(self, ram: ByteArray) -> IntArray:
        """The values (..., M) of RAM (..., 128); -1 where bytes are no decimal number."""
        digits = _DIGITS[ram] if self.decimal else ram.astype(np.int64)
        digits = np.concatenate([digits, np.zeros((*ram.shape[:-1], 1), np.int64)], axis=-1)[..., self._bytes]
        values: IntArray = (digits * 100 ** np.arange(self._bytes.shape[1])).sum(-1) * self._units
        return np.where((digits < 0).any(-1), -1, values)
