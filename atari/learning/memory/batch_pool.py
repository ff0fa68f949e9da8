"""`BatchPool` reuses the memory of the batches that `ReplayMemory.sample` makes.

The system clears new memory page by page when it is first written. For a batch of 32 that takes longer than sampling.
"""

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import atari._emulator as _emulator
from atari.learning.memory.batches import Batch, Sequences, make_batch, target_of
from atari.learning.memory.options import MemoryOptions

_MOST_BYTES = 2**26  # larger batches are not kept
_ALIGNMENT = 64

_Key = tuple[int, int, tuple[int, ...]]  # size, length, stacks


class _Arena:
    """Makes arrays one after the other in a buffer; without one, it counts the bytes that they need."""

    def __init__(self, buffer: Any = None) -> None:
        self.buffer, self.end = buffer, 0

    def __call__(self, shape: tuple[int, ...], dtype: Any) -> npt.NDArray[Any]:
        start, kind = self.end, np.dtype(dtype)
        count = kind.itemsize
        for size in shape:
            count *= size
        self.end = start + -(-count // _ALIGNMENT) * _ALIGNMENT
        return np.empty(0, kind) if self.buffer is None else np.ndarray(shape, kind, self.buffer, start)


@dataclass(frozen=True, eq=False)
class _Kept:
    """The memory of a batch. It is free when the user holds no array in it any more."""

    key: _Key
    lender: _emulator.ArrayLender
    target: _emulator.ReplayTarget


class BatchPool:
    """The memory of the last two batches that were made. Threads may share it."""

    def __init__(self, options: MemoryOptions) -> None:
        self._options = options
        self._kept: deque[_Kept] = deque(maxlen=2)

    def take(
        self, core: _emulator.ReplayMemory, size: int, length: int, stacks: dict[str, int]
    ) -> tuple[Batch | Sequences, _emulator.ReplayTarget]:
        """A batch without other references, and the target through which the extension module writes it."""
        key = (size, length, tuple(stacks.values()))
        kept = self._unused(key)
        if kept is None:
            make_batch(self._options, size, length, stacks, arena := _Arena())
            if arena.end > _MOST_BYTES:
                batch = make_batch(self._options, size, length, stacks)
                return batch, target_of(batch, core, self._options, size, length)
            memory = np.empty(arena.end, np.uint8)
            whole = make_batch(self._options, size, length, stacks, _Arena(memory))
            kept = _Kept(key, _emulator.ArrayLender(memory), target_of(whole, core, self._options, size, length))
        batch = make_batch(self._options, size, length, stacks, _Arena(kept.lender.lend()))
        self._kept.append(kept)
        return batch, kept.target

    def _unused(self, key: _Key) -> _Kept | None:
        """Take free memory out of the pool, so that no other thread can take it."""
        for _ in range(len(self._kept)):
            try:
                kept = self._kept.popleft()
            except IndexError:  # another thread has it
                return None
            if kept.key == key and not kept.lender.lent:
                return kept
            self._kept.append(kept)
        return None
