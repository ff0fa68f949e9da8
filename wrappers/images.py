"""`resize_image` and `rgb_to_gray`: OpenCV's INTER_AREA and RGB2GRAY, equal in every byte, without OpenCV."""

from typing import Any

import numpy as np

import atari._emulator as _emulator
from atari.base.validation import check_integer
from atari.cores import ByteArray

LONGEST_SIDE = 32_768
"""The most rows, columns and channels of an image."""


def resize_image(image: Any, shape: tuple[int, int]) -> ByteArray:
    """An image in another size, as by `cv2.resize(..., interpolation=cv2.INTER_AREA)`.

    If no side grows, a pixel of the result is the mean of the area that it covers; otherwise both directions are
    interpolated linearly. Tests compare all sizes with OpenCV's bytes.

    Args:
        image: (rows, columns) or (rows, columns, channels) uint8, each axis at most 32,768.
        shape: (rows, columns) of the result.

    Returns:
        A new array, (rows, columns) or (rows, columns, channels) uint8. (OpenCV drops an axis of one channel.)

    Raises:
        TypeError, ValueError: `image` is no such array, or `shape` is not two integers within 1..32768.

    Example:
        >>> import numpy as np
        >>> from atari.wrappers import resize_image
        >>> resize_image(np.array([[0, 100, 10, 10], [100, 200, 10, 30]], np.uint8), (1, 2))
        array([[100,  15]], dtype=uint8)
    """
    if not isinstance(shape, (tuple, list)) or len(shape) != 2:
        raise TypeError(f"shape must be two integers (rows, columns), got {shape!r}")
    rows, columns = (check_integer("shape", length, 1, LONGEST_SIDE) for length in shape)
    return _emulator.resize_image(np.ascontiguousarray(image), rows, columns)


def rgb_to_gray(image: Any) -> ByteArray:
    """The brightness of each pixel, 0.299 red + 0.587 green + 0.114 blue, as by `cv2.cvtColor(..., COLOR_RGB2GRAY)`.

    Args:
        image: (rows, columns, 3) uint8, each axis at most 32,768.

    Returns:
        A new array, (rows, columns) uint8.

    Raises:
        TypeError, ValueError: `image` is no such array.

    Example:
        >>> import numpy as np
        >>> from atari.wrappers import rgb_to_gray
        >>> rgb_to_gray(np.array([[[255, 0, 0], [200, 72, 72]]], np.uint8))
        array([[ 76, 110]], dtype=uint8)
    """
    return _emulator.rgb_to_gray(np.ascontiguousarray(image))
