"""Image operations before encoding: enlarging, captions, and the colour palette of a GIF."""

import numpy as np
import numpy.typing as npt

from atari.base import font
from atari.cores import ByteArray

_MARGIN = 2
"""The pixels left of a caption and above each of its lines, at scale 1."""


def enlarge(rgb: ByteArray, across: int, down: int) -> ByteArray:
    """Return an image (rows, columns, 3) with each pixel as a block: (down * rows, across * columns, 3) uint8."""
    return rgb.repeat(down, 0).repeat(across, 1)


def line_height(scale: int) -> int:
    """Return the height of a caption line in rows."""
    return (_MARGIN + font.ROWS) * scale


def caption_room(columns: int) -> int:
    """Return the characters of a caption line below a screen of this many columns, before it is enlarged."""
    return (2 * columns - _MARGIN) // font.COLUMNS


def add_caption(image: ByteArray, text: str, lines: int, scale: int) -> ByteArray:
    """Return the image (rows, columns, 3) with lines of white text on black added below it.

    The height grows by `lines * line_height(scale)` rows. The font is monospaced; 53 characters fit below a game's
    screen. Characters outside ASCII become "?".
    """
    height, width = image.shape[:2]
    whole = np.zeros((height + lines * line_height(scale), width, 3), np.uint8)
    whole[:height] = image
    margin = _MARGIN * scale
    for number, line in enumerate(text.splitlines()[:lines]):
        font.write(whole, line, margin, height + margin + number * line_height(scale), (255, 255, 255), scale)
    return whole


class Palette:
    """The colours of a video by index, in the order of their appearance.

    The console has 128 colours and an indexed image up to 256, so a game's frames are lossless. Further colours are
    mapped to the nearest of the first 256.
    """

    def __init__(self) -> None:
        self.colours = np.zeros((256, 4), np.uint8)
        """Opacity, red, green, blue of each index."""
        self.colours[:, 0] = 255
        self._count = 0
        self._index_of = np.zeros(1 << 24, np.uint16)  # index + 1 by RGB code; sparsely used pages

    def indices(self, image: ByteArray) -> ByteArray:
        """Return the colour indices of an image (rows, columns, 3): (rows, columns) uint8."""
        codes: npt.NDArray[np.int32] = np.zeros(image.shape[:2], "<i4")  # a fourth byte beside blue, green and red
        codes.view(np.uint8).reshape(*image.shape[:2], 4)[..., 2::-1] = image
        indices = self._index_of.take(codes)
        if not indices.all():
            for code in np.unique(codes[indices == 0]).tolist():
                self._index_of[code] = 1 + self._add((code >> 16, code >> 8 & 255, code & 255))
            indices = self._index_of.take(codes)
        return np.asarray(indices - 1, np.uint8)

    def _add(self, colour: tuple[int, int, int]) -> int:
        if self._count < 256:
            self.colours[self._count, 1:] = colour
            self._count += 1
            return self._count - 1
        distances: npt.NDArray[np.int64] = ((self.colours[:, 1:].astype(np.int64) - colour) ** 2).sum(axis=1)
        return int(distances.argmin())
