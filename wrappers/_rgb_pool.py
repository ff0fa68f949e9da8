"""`RgbPool`: the gray values of two frames pooled as RGB, without converting the frames to RGB.

A frame is palette indices, so the gray value of two pooled pixels depends on two indices, and a table has all pairs.
Most pixels of successive frames are equal: OpenCV looks them up by one index, which is fast; the others need both.
"""

from functools import cache

import cv2
import numpy as np

from atari.cores import ByteArray
from atari.wrappers._palettes import PALETTES


class RgbPool:
    """Pools frames of palette indices of a TV format. The result is OpenCV's gray of the maximum of their colours."""

    def __init__(self, tv_format: str) -> None:
        self._of_pair = gray_of_pairs(tv_format)
        self._of_one = np.ascontiguousarray(self._of_pair.diagonal())

    def gray(self, frame: ByteArray, out: ByteArray) -> ByteArray:
        """The gray values of one frame, uint8 of its shape, written to `out`."""
        cv2.LUT(frame, self._of_one, dst=out)
        return out

    def pooled(self, early: ByteArray, late: ByteArray, out: ByteArray) -> ByteArray:
        """The gray values of two frames, pooled, uint8 of their shape, written to `out`."""
        self.gray(late, out)
        early, late = early.ravel(), late.ravel()
        (differing,) = (early != late).nonzero()
        out.ravel()[differing] = self._of_pair[early[differing], late[differing]]
        return out


@cache
def gray_of_pairs(tv_format: str) -> ByteArray:
    """The gray value of the maximum of two colours by their palette indices, (256, 256) uint8."""
    palette = PALETTES[tv_format]
    table: ByteArray = cv2.cvtColor(np.maximum(palette[:, None], palette[None]), cv2.COLOR_RGB2GRAY)  # type: ignore[assignment]
    return table
