"""Displays of environments, games and replays in a notebook: HTML that contains its images.

An animation is an animated PNG, which every browser plays. This module joins its frames itself. OpenCV encodes
animations in memory only since version 4.12, which needs NumPy 2. It also takes all frames at once, although a long
replay must stop at a size limit.
"""

import base64
import html
import re
import struct
import zlib
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.base.text_table import Table

ByteArray = npt.NDArray[np.uint8]

MAX_ANIMATION_SIZE = 2_000_000
"""The most bytes of an animation; it ends before the frame that would exceed them."""

MOST_SHOWN = 36
"""The most environments of a vector that a notebook shows."""

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_OVERWRITE_AND_KEEP = (0, 0)


def png(image: ByteArray) -> bytes:
    """An RGB image, (height, width, 3) uint8, as a PNG file."""
    import cv2  # here, because the import takes long

    return bytes(cv2.imencode(".png", image[..., ::-1])[1])


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


def picture(data: bytes, caption: str, shape: Sequence[int]) -> str:
    """HTML of a PNG file of screens, see `image`, with a caption below."""
    shown = image(data, caption, shape)
    return f'<figure style="margin:0">{shown}<figcaption>{html.escape(caption)}</figcaption></figure>'


def image(data: bytes, text: str, shape: Sequence[int]) -> str:
    """An HTML image of a PNG file of one or more screens, at most as wide as the page, with a text for readers.

    `shape` begins with the rows and columns of the file. The pixels of a screen are twice as wide as high, and a
    browser takes the aspect of the file for `height:auto`. So the style has the aspect of the attributes.
    """
    width, height = 2 * shape[1], shape[0]
    style = f"image-rendering:pixelated;max-width:100%;height:auto;aspect-ratio:{width}/{height}"
    return (
        f'<img width="{width}" height="{height}" alt="{html.escape(text)}" style="{style}" '
        f'src="data:image/png;base64,{base64.b64encode(data).decode()}">'
    )


def facts(title: str, rows: Sequence[tuple[str, Any]], note: str = "") -> str:
    """HTML of a table with a name and a value a row, without the rows whose value is None or empty."""
    body = "".join(
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(str(value))}</td></tr>'
        for name, value in rows
        if value not in (None, "")
    )
    below = f"<p>{html.escape(note)}</p>" if note else ""
    return f"<p><strong>{html.escape(title)}</strong></p>{below}<table><tbody>{body}</tbody></table>"


def report(text: str) -> str:
    """HTML of what an object prints: a title line, sentences, and tables, which have an empty line before and after.

    A table is a paragraph of columns as `text_table.aligned` makes them, with two or more spaces between them in all
    lines; its first line has the titles.
    """
    title, _, rest = text.partition("\n")
    return f"<p><strong>{html.escape(title)}</strong></p>" + "".join(map(_paragraph, rest.split("\n\n")))


def _paragraph(text: str) -> str:
    lines = text.strip("\n").split("\n")
    width = max(map(len, lines))
    used = "".join("x" if any(line[at : at + 1].strip() for line in lines) else " " for at in range(width))
    columns = [slice(*match.span()) for match in re.finditer(r"x+( x+)*", used)]
    if len(lines) > 1 and len(columns) > 1:
        head, *rows = ([line[column].strip() for column in columns] for line in lines)
        return f'<div style="margin:1em 0">{Table.of(head, rows)._repr_html_()}</div>'
    return "".join(f"<p>{html.escape(line)}</p>" for line in lines)


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
    return _chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))  # 8 bits, RGB


def _pixels(image: ByteArray) -> bytes:
    """The compressed rows, each after a filter byte that means no filter."""
    height, width = image.shape[:2]
    rows = np.zeros((height, 1 + 3 * width), np.uint8)
    rows[:, 1:] = image.reshape(height, 3 * width)
    return zlib.compress(rows.tobytes(), 6)


def _chunk(kind: bytes, data: bytes = b"") -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
