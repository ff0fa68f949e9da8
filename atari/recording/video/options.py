"""`VideoOptions`: the validated options of a `VideoWriter`."""

import re
from dataclasses import dataclass
from fractions import Fraction
from numbers import Rational, Real
from os import PathLike
from pathlib import Path
from typing import Any

from atari.base.validation import check_integer
from atari.recording.video.formats import FORMATS, Format, is_picture
from atari.recording.video.images import line_height


@dataclass(frozen=True)
class VideoOptions:
    """The options of a `VideoWriter` after validation."""

    path: Path
    format: Format
    shape: tuple[int, int, int]  # a frame's, before scaling
    rate: Fraction
    scale: int
    pixel_aspect: tuple[int, int]
    sound: bool
    caption_lines: int

    @classmethod
    def check(
        cls,
        path: str | PathLike[str],
        size: Any,
        fps: Any,
        *,
        scale: Any,
        sound: Any,
        caption_lines: Any,
        pixel_aspect: Any = (2, 1),
    ) -> "VideoOptions":
        """Validate a user's options and return them.

        Raises:
            TypeError, ValueError: an option has the wrong type or is out of range.
        """
        format = _check_format(Path(path))
        if sound and format.sound is None:
            raise ValueError(f"{format.name} has no sound; write it with sound=False")
        if not isinstance(size, (tuple, list)) or len(size) != 2:
            raise TypeError(f"size is a Game, or (rows, columns) of the frames, got {size!r}")
        if not isinstance(pixel_aspect, (tuple, list)) or len(pixel_aspect) != 2:
            raise TypeError(f"pixel_aspect is (columns, rows) of a pixel, such as (1, 1), got {pixel_aspect!r}")
        across, down = (check_integer("a side of pixel_aspect", side, 1, 16) for side in pixel_aspect)
        rows, columns = (check_integer("a side of size", side, 1, format.limit) for side in size)
        options = cls(
            path=Path(path),
            format=format,
            shape=(rows, columns, 3),
            rate=_check_rate(fps),
            scale=check_integer("scale", scale, 1, 16),
            pixel_aspect=(across, down),
            sound=bool(sound),
            caption_lines=check_integer("caption_lines", caption_lines, 0, 1000),
        )
        if any(side % format.multiple or side > format.limit for side in (options.width, options.height)):
            sides = "even sides" if format.multiple == 2 else "sides"
            raise ValueError(
                f"the video would be {options.width}x{options.height}, but {format.name} needs {sides} up to "
                f"{format.limit}; choose another scale than {scale}"
            )
        return options

    @property
    def width(self) -> int:
        """Columns of the video."""
        return self.pixel_aspect[0] * self.scale * self.shape[1]

    @property
    def height(self) -> int:
        """Rows of the video."""
        return self.pixel_aspect[1] * self.scale * self.shape[0] + self.caption_lines * line_height(self.scale)


def _check_format(path: Path) -> Format:
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"a video's name must end in one of {', '.join(FORMATS)}, got {str(path)!r}")
    if suffix == ".png" and not is_picture(path) and not re.fullmatch(r"[^%]*%0?\d*d[^%]*", path.name):
        raise ValueError(
            f"a PNG is one frame, so a name with % must have a place for its number, such as '%06d.png', "
            f"got {str(path)!r}"
        )
    return FORMATS[suffix]


def _check_rate(fps: Any) -> Fraction:
    if not isinstance(fps, Real):
        raise TypeError(f"fps is a number of frames a second, which only a Game implies, got {fps!r}")
    if not 0.001 <= float(fps) <= 1000:
        raise ValueError(f"fps must be within 0.001..1000, got {fps}")
    # MP4 stores times as 32-bit fractions of a second; the console's frame rates have far smaller denominators.
    return Fraction(fps if isinstance(fps, Rational) else float(fps)).limit_denominator(1_000_000)
