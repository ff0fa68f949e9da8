"""Recorded histories of RAM: replays and arrays, as arrays (T, N, 128) uint8: T states of N games."""

from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray
from atari.games.catalog import games
from atari.recording import Replay

RAM_BYTES = 128


def recorded(source: Any) -> ByteArray | None:
    """The states of a recording: one after each emulated frame of a replay, or the rows of an array; else None.

    Args:
        source: a `Replay`, the path of one (.a26r), or an array (T, 128) or (T, N, 128), uint8.

    Raises:
        TypeError, ValueError: the array has another shape, or its values are no bytes; or as `Replay.load`.
        FileNotFoundError: there is no such file.
    """
    if isinstance(source, (str, PathLike)):
        if isinstance(source, str) and source in games:
            raise TypeError(
                f"RAM is read from a game that is played, so take an environment, such as atari.make({source!r}), or a "
                "recorded game: the path of a replay (.a26r)"
            )
        source = Replay.load(source)
    if isinstance(source, Replay):
        return _replayed(source)
    if isinstance(source, (np.ndarray, list, tuple)):
        return _checked(np.asarray(source))
    return None


def check_index(index: Any, count: int) -> int:
    """The index of one of `count` recorded games.

    Raises:
        IndexError: there is no such game.
    """
    if isinstance(index, (int, np.integer)) and 0 <= index < count:
        return int(index)
    raise IndexError(f"there is no game {index!r} in this history; it has 0..{count - 1}")


def _replayed(replay: Replay) -> ByteArray:
    rows = np.empty((replay.frames_total, 1, RAM_BYTES), np.uint8)
    count = 0
    core = replay.make_env().core
    try:
        for _, calls in replay.walk(core):  # `Replay.frames` also renders each frame
            for call in calls:
                if call.played and count < len(rows):
                    core.ram(rows[count, 0])
                    count += 1
    finally:
        core.close()
    return rows[:count]


def _checked(array: npt.NDArray[Any]) -> ByteArray:
    if array.ndim not in (2, 3) or array.shape[-1] != RAM_BYTES:
        raise ValueError(f"a history of RAM is an array (T, 128) or (T, N, 128), got {array.shape}")
    if array.dtype != np.uint8:
        if array.dtype.kind not in "iu" or (array.size and not 0 <= array.min() <= array.max() <= 0xFF):
            raise TypeError(f"a history of RAM holds bytes, integers 0..255, got {array.dtype}")
        array = array.astype(np.uint8)
    return array[:, None] if array.ndim == 2 else array
