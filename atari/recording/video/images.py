"""Image operations before encoding: enlarging, captions, and the colour palette of a GIF."""

from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from atari.cores import ByteArray

_GLYPH_COLUMNS = 5  # at scale 1


def enlarge(rgb: ByteArray, across: int, down: int) -> ByteArray:
    """Return an image (rows, columns, 3) with each pixel as a block: (down * rows, across * columns, 3) uint8."""
    rows, columns = rgb.shape[:2]
    size = (across * columns, down * rows)
    return np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_NEAREST), np.uint8)


def line_height(scale: int) -> int:
    """Return the height of a caption line in rows."""
    return 8 * scale


def caption_room(columns: int) -> int:
    """Return the characters of a caption line below a screen of this many columns, before it is enlarged."""
    return 2 * columns // _GLYPH_COLUMNS


def add_caption(image: ByteArray, text: str, lines: int, scale: int) -> ByteArray:
    """Return the image (rows, columns, 3) with lines of white text on black added below it.

    The height grows by `lines * line_height(scale)` rows. The font is monospaced; 64 characters fit below a game's
    screen. Characters outside ASCII become "?".
    """
    glyphs = _glyphs(scale)
    _, rows, columns = glyphs.shape
    height, width = image.shape[:2]
    room = width // columns
    padded = "".join(line[:room].ljust(room) for line in [*text.splitlines(), *[""] * lines][:lines])
    codes = np.frombuffer(padded.encode("ascii", "replace"), np.uint8).reshape(lines, room)
    band = glyphs[codes & 127].transpose(0, 2, 1, 3).reshape(lines * rows, room * columns)
    whole = np.zeros((height + lines * rows, width, 3), np.uint8)
    whole[:height] = image
    whole[height:, : room * columns] = band[..., np.newaxis]
    return whole


@lru_cache(maxsize=16)
def _glyphs(scale: int) -> ByteArray:
    """Return the glyphs of ASCII's characters, (128, rows, columns).

    OpenCV's font has glyphs of different widths; each is centred in its cell.
    """
    rows, columns = line_height(scale), _GLYPH_COLUMNS * scale
    glyphs = np.zeros((128, rows, columns), np.uint8)
    for code in range(33, 127):
        drawn = np.zeros((rows, 3 * columns), np.uint8)
        place = (columns, 6 * scale)
        cv2.putText(drawn, chr(code), place, cv2.FONT_HERSHEY_PLAIN, scale / 2, (255,), 1, cv2.LINE_AA)
        inked = np.flatnonzero(drawn.any(0))
        left = (inked[0] + inked[-1] + 1 - columns) // 2
        glyphs[code] = drawn[:, left : left + columns]
    return glyphs


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
