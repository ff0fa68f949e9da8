"""Arrays for `out=`, between bytes that must not change."""

import math
import random
from typing import Any

import numpy as np
import numpy.typing as npt

BESIDE = 304  # bytes on each side of an array, more than the widest store
GUARD = 0xA5


class Guards:
    """Makes arrays, and checks the bytes beside them."""

    def __init__(self, source: random.Random) -> None:
        self._source = source
        self._made: list[tuple[npt.NDArray[np.uint8], slice]] = []

    def array(self, shape: tuple[int, ...], dtype: npt.DTypeLike = np.uint8) -> npt.NDArray[Any]:
        """An array at an address of any alignment that its dtype allows, full of guard bytes."""
        kind = np.dtype(dtype)
        size = math.prod(shape) * kind.itemsize
        first = BESIDE + kind.itemsize * self._source.randrange(64 // kind.itemsize)
        place = slice(first, first + size)
        memory = np.full(size + 2 * BESIDE + 64, GUARD, np.uint8)
        self._made.append((memory, place))
        return memory[place].view(kind).reshape(shape)

    def check(self) -> None:
        """AssertionError if a byte beside one of the arrays has changed."""
        for memory, place in self._made:
            assert (np.delete(memory, place) == GUARD).all(), "bytes beside an array of the caller were written"
