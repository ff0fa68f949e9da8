"""PNG files of images, and animated ones, which every browser plays.

Rows have no filter. Images of games have few colours and long runs, of which zlib alone makes smaller files than after
a filter for photographs.
"""

import struct
import zlib
from collections.abc import Iterable, Iterator
from itertools import islice

import numpy as np
import numpy.typing as npt

ByteArray = npt.NDArray[np.uint8]

MAX_ANIMATION_SIZE = 2_000_000
"""The most bytes of an animation; it ends before the frame that would exceed them."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_OVERWRITE_AND_KEEP = (0, 0)
_KINDS = {(): 0, (1,): 0, (2,): 4, (3,): 2, (4,): 6}  # gray; gray and opacity; red, green, blue; these and opacity


def png(image: ByteArray) -> bytes:
    """An image as a PNG file: (height, width) uint8 of grays, or (height, width, channels), see `_KINDS`."""
    return b"".join((_SIGNATURE, _header(image), _chunk(b"IDAT", _pixels(image)), _chunk(b"IEND")))


def animation(images: Iterable[ByteArray], rate: int) -> tuple[bytes, int]:
    """RGB images of one size as an animated PNG that loops; a frame holds only the rectangle that has changed.

    Args:
        images: at least one, (height, width, 3) uint8.
        rate: images a second.

    Returns:
        The file, and the number of images that it shows: fewer than all if it would exceed `MAX_ANIMATION_SIZE`.

    Raises:
        ValueError: there is no image.
    """
    chunks: list[bytes] = []
    size = shown = 0
    header = b""
    for image, (top, left, bottom, right) in _changes(images):
        header = header or _header(image)
        part = image[top:bottom, left:right]
        place = struct.pack(">5I", 2 * shown - (shown > 0), right - left, bottom - top, left, top)
        control = _chunk(b"fcTL", place + struct.pack(">2H2B", 1, rate, *_OVERWRITE_AND_KEEP))
        pixels = _pixels(part)
        data = _chunk(b"fdAT", struct.pack(">I", 2 * shown) + pixels) if shown else _chunk(b"IDAT", pixels)
        size += len(control) + len(data)
        if shown and size > MAX_ANIMATION_SIZE:
            break
        chunks += control, data
        shown += 1
    if not shown:
        raise ValueError("an animation needs an image")
    count = _chunk(b"acTL", struct.pack(">2I", shown, 0))
    return b"".join((_SIGNATURE, header, count, *chunks, _chunk(b"IEND"))), shown


def pooled(images: Iterable[ByteArray], size: int) -> Iterator[ByteArray]:
    """The brightest value of each pixel in `size` images at a time: games draw some objects every second frame."""
    rest = iter(images)
    while group := list(islice(rest, size)):
        yield np.maximum.reduce(group)


def _changes(images: Iterable[ByteArray]) -> Iterator[tuple[ByteArray, tuple[int, int, int, int]]]:
    """Each image with the rectangle that differs from the one before: top, left, bottom, right; never empty."""
    before: ByteArray | None = None
    for image in images:
        if before is None:
            yield image, (0, 0, *image.shape[:2])
        else:
            differs = (image != before).any(axis=2)
            rows, columns = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
            if len(rows):
                yield image, (int(rows[0]), int(columns[0]), int(rows[-1]) + 1, int(columns[-1]) + 1)
            else:
                yield image, (0, 0, 1, 1)
        before = image


def _header(image: ByteArray) -> bytes:
    height, width = image.shape[:2]
    return _chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, _KINDS[image.shape[2:]], 0, 0, 0))


def _pixels(image: ByteArray) -> bytes:
    """The compressed rows, each after a filter byte that means no filter."""
    rows = image.reshape(len(image), -1)
    return zlib.compress(np.insert(rows, 0, 0, axis=1).tobytes(), 6)


def _chunk(kind: bytes, data: bytes = b"") -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
