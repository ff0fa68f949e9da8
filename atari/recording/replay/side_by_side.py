"""`write_film`: a video or a picture of a replay, or of several beside each other with their names."""

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import zip_longest
from os import PathLike
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from atari.base.validation import check_integer
from atari.cores import ByteArray
from atari.recording.replay.results import Frame
from atari.recording.video.formats import FORMATS, is_picture
from atari.recording.video.images import add_caption, caption_room, enlarge, line_height
from atari.recording.video.overlay import Overlay
from atari.recording.video.writer import VideoWriter

_IN_A_ROW = 3  # more replays make a square
_GAP = 8  # rows of a screen; the columns between two replays are as wide


def write_film(
    path: str | PathLike[str],
    parts: Sequence[Iterator[Frame]],
    overlays: Sequence[Overlay],
    shapes: Sequence[tuple[int, int]],
    names: Sequence[str],
    rate: Fraction,
    *,
    scale: int,
    progress: Callable[[int], object] | None,
    **options: Any,
) -> Path:
    """Write the frames of replays, until the longest has ended, with the sound of the first; return the file.

    Args:
        path, rate, scale, options: see `VideoWriter`.
        parts: the frames of each replay.
        overlays: what is below the screen of each.
        shapes: (rows, columns) of their screens.
        names: the first line below each, see `labels`; "" means none.
        progress: called with 1 after each frame.

    Raises:
        TypeError, ValueError, OSError, gymnasium.error.DependencyNotInstalled: see `VideoWriter`; a picture has no
            frame.
    """
    several = len(parts) > 1
    shown = list(map(_Shown, overlays, names))
    sizes = [overlay.size(shape) for overlay, shape in zip(overlays, shapes, strict=True)]
    if several:
        image = _Mosaic(shown, sizes, check_integer("scale", scale, 1, 16))
        image.check(Path(path))
        video = VideoWriter(path, image.size, rate, scale=1, pixel_aspect=(1, 1), **options)
    else:
        video = VideoWriter(path, sizes[0], rate, scale=scale, caption_lines=overlays[0].caption_lines, **options)
    with video:

        def write(first: Frame | None) -> None:
            drawn = (image.draw(), "") if several else shown[0].draw()
            video.write(drawn[0], None if first is None else first.audio, drawn[1])

        for frames in zip_longest(*parts):
            for one, frame in zip(shown, frames, strict=True):
                if frame is not None:
                    one.add(frame)
            if not is_picture(path):
                write(frames[0])
            if progress is not None:
                progress(1)
        if is_picture(path):
            write(shown[0].frame)
    return video.path


class _Shown:
    """The newest frame of a replay, with its overlay.

    Args:
        overlay: the overlay, which this object changes.
        name: the first line below the screen; "" means none.
    """

    frame: Frame | None = None
    """The newest frame; None before the first."""

    def __init__(self, overlay: Overlay, name: str = "") -> None:
        self._overlay, self._name = overlay, name
        self.caption_lines = overlay.caption_lines + bool(name)

    def add(self, frame: Frame) -> None:
        """Show this frame, which follows the last one."""
        if self.frame is not None and frame.episode != self.frame.episode:
            self._overlay.begin_game()
        self._overlay.add(frame.score - self._overlay.score)  # also after a rewind
        self.frame = frame

    def draw(self) -> tuple[ByteArray, str]:
        """The screen with the overlay's curve, (rows, columns, 3) uint8, and the text below it.

        Raises:
            ValueError: there is no frame.
        """
        frame = self.frame
        if frame is None:
            raise ValueError("there is no frame for a picture; show another part")
        words = self._overlay.caption(frame.actions, frame.ram, frame.scores, frame.all_lives)
        return self._overlay.draw(frame.screen), "\n".join(filter(None, (self._name, words)))


class _Mosaic:
    """The image of several replays: up to three in a row, or a square. A lower screen is in the middle of its place.

    Args:
        shown: the replays.
        sizes: (rows, columns) of their images.
        scale: a pixel becomes `2 * scale` columns and `scale` rows.
    """

    def __init__(self, shown: Sequence[_Shown], sizes: Sequence[tuple[int, int]], scale: int) -> None:
        self._shown, self._scale = shown, scale
        self._drawn: list[Frame | None] = [None] * len(shown)
        self._lines = max(one.caption_lines for one in shown)
        height = scale * max(rows for rows, _ in sizes)
        width = 2 * scale * max(columns for _, columns in sizes)
        self._place = (height, width)
        gap, across = _GAP * scale, len(shown) if len(shown) <= _IN_A_ROW else math.ceil(math.sqrt(len(shown)))
        down, step = math.ceil(len(shown) / across), (height + self._lines * line_height(scale) + gap, width + gap)
        self._corners = [(step[0] * (i // across), step[1] * (i % across)) for i in range(len(shown))]
        sides = (down * step[0] - gap, across * step[1] - gap)
        self._image = np.zeros((*(side + side % 2 for side in sides), 3), np.uint8)  # MP4 needs even sides

    @property
    def size(self) -> tuple[int, int]:
        """(rows, columns) of the image."""
        rows, columns, _ = self._image.shape
        return rows, columns

    def check(self, path: Path) -> None:
        """Refuse an image that is too large for a format.

        Raises:
            ValueError: it is too large.
        """
        format, (rows, columns) = FORMATS.get(path.suffix.lower()), self.size
        if format is not None and max(rows, columns) > format.limit:
            raise ValueError(
                f"the video of {len(self._shown)} replays would be {columns}x{rows}, but {format.name} has sides up to "
                f"{format.limit}; choose a scale below {self._scale}, or fewer replays"
            )

    def draw(self) -> ByteArray:
        """The image, (rows, columns, 3) uint8. The next call changes it."""
        for number, (shown, (top, left)) in enumerate(zip(self._shown, self._corners, strict=True)):
            if shown.frame is not self._drawn[number]:
                self._drawn[number] = shown.frame
                cell = self._cell(*shown.draw())
                self._image[top : top + cell.shape[0], left : left + cell.shape[1]] = cell
        return self._image

    def _cell(self, image: ByteArray, caption: str) -> ByteArray:
        screen = enlarge(image, 2 * self._scale, self._scale)
        place = np.zeros((*self._place, 3), np.uint8)
        top = (self._place[0] - screen.shape[0]) // 2
        place[top : top + screen.shape[0], : screen.shape[1]] = screen
        return add_caption(place, caption, self._lines, self._scale)


def labels(names: Sequence[str], columns: int) -> list[str]:
    """Names of replays for the line below their screens, which have this many columns.

    Of a path they have the last parts, as many as tell the replays apart. Long ones lose their middle, and equal ones
    get a number.
    """
    parts = [PurePath(name).parts or (name,) for name in names]
    most = max(map(len, parts))
    tails = (["/".join(each[-count:]) for each in parts] for count in range(1, most + 1))
    distinct = len(set(parts))
    short = next(tail for tail in tails if len(set(tail)) == distinct)
    room = caption_room(columns) - len(f" ({len(names)})")
    short = [_without_middle(name, room) for name in short]
    return [
        name if short.count(name) == 1 else f"{name} ({short[: i + 1].count(name)})" for i, name in enumerate(short)
    ]


def _without_middle(name: str, room: int) -> str:
    if len(name) <= room:
        return name
    half = (room - 3) // 2
    return f"{name[: room - 3 - half]}...{name[len(name) - half :]}"
