"""The choice of the frame to show of a game, and sheets of many frames in one picture."""

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]


def detail(screen: Image) -> int:
    """The number of pixels that differ from the one to their left: high where much is on the screen."""
    return int((screen[:, 1:] != screen[:, :-1]).any(axis=2).sum())


def busiest(screens: Iterable[Image]) -> Image:
    """The screen with the most detail, the first of equals."""
    return max(screens, key=detail)


def shape(cells: int) -> tuple[int, int]:
    """(columns, rows) of a sheet of n cells."""
    columns = min(cells, 8)
    return columns, -(-cells // columns)


def sheet(screens: Sequence[Image]) -> Image:
    """Images of one size in rows, black after the last."""
    columns, rows = shape(len(screens))
    blank = np.zeros_like(screens[0])
    filled = [*screens, *[blank] * (columns * rows - len(screens))]
    return np.concatenate([np.concatenate(filled[row * columns :][:columns], axis=1) for row in range(rows)])
