"""`VideoWriter`: screens in, an H.264 MP4 out, frame by frame and in constant memory.

A video is right when it looks and moves as the console did on a television. The console's pixels are about twice
as wide as high, so each becomes a block of 2 x 1 times an integer scale: no pixel is blurred, none is wider than its
neighbour. And the console's frame rate is no round number; it follows from the clock that draws the colours.

The encoder is x264 inside PyAV (extra `video`). The file is written in fragments while recording and made an ordinary
MP4 at the end, so that a killed process leaves what it had recorded up to the last few seconds.
"""

from fractions import Fraction
from numbers import Rational, Real
from os import PathLike
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import Any

import numpy as np

from atari.cores import ByteArray
from atari.cores.options import check_integer
from atari.game import Game
from atari.recording.audio import SAMPLES_PER_FRAME
from atari.recording.formats import FORMATS
from atari.recording.movie import Movie

COLOUR_CLOCKS_PER_LINE = 228
COLOUR_CLOCK_HZ = MappingProxyType(
    {
        "NTSC": Fraction(315_000_000, 88),  # the colour subcarrier, 3.579545 MHz
        "PAL": Fraction(3_546_895),  # four fifths of the colour subcarrier, 4.43361875 MHz
        "SECAM": Fraction(228 * 15_625),  # the standard's 15,625 lines a second
    }
)
LINES_PER_FRAME = MappingProxyType({"NTSC": 262, "PAL": 312, "SECAM": 312})


def frame_rate(game: Game) -> Fraction:
    """Frames a second of the console that shows `game`: 59.92 with NTSC, 49.86 with PAL.

    Exact for a game that draws the lines of its TV format (262 or 312 of 228 colour clocks each), as nearly all do.
    Divide it by the frame skip for a video of one screen a step.
    """
    tv = game.screen.format
    return COLOUR_CLOCK_HZ[tv] / (COLOUR_CLOCKS_PER_LINE * LINES_PER_FRAME[tv])


class VideoWriter:
    """A video file that grows by one screen, with its sound, at each `write`.

    Use it in a `with` statement, or call `close`; only then is the file complete. A writer that is closed without a
    screen leaves no file.

    Args:
        path: of the file; its ending chooses the format, see `atari.recording.FORMATS`. Its folder is made, and a file
            of this name replaced.
        size: (rows, columns) of the screens, such as `game.screen.shape`.
        fps: screens a second, such as `frame_rate(game)`.
        scale: a pixel of the screen becomes `2 * scale` columns and `scale` rows of the video. MP4 stores colours
            for blocks of 2 x 2, so with an odd scale the colours of neighbouring rows mix at edges.
        sound: the video has a sound track. Each screen's samples last as long as the screen does, so `fps` must be
            that of emulated frames, not of steps.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range.
        OSError: the file cannot be written.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
    """

    frames: int = 0
    """Screens written so far."""

    def __init__(
        self,
        path: str | PathLike[str],
        size: tuple[int, int],
        fps: Fraction | float,
        *,
        scale: int = 2,
        sound: bool = False,
    ) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() not in FORMATS:
            raise ValueError(f"a video's name must end in one of {', '.join(map(repr, FORMATS))}, got {str(path)!r}")
        format = FORMATS[self.path.suffix.lower()]
        self.sound = bool(sound)
        if self.sound and format.sound is None:
            raise ValueError(f"{format.name} has no sound; write it with sound=False")
        self._scale = check_integer("scale", scale, 1, 16)
        if not isinstance(size, (tuple, list)) or len(size) != 2:
            raise TypeError(f"size is (rows, columns) of the screens, got {size!r}")
        rows, columns = (check_integer("a side of size", side, 1, format.limit) for side in size)
        self._shape = (rows, columns, 3)
        width, height = 2 * self._scale * columns, self._scale * rows
        if height % format.multiple or max(width, height) > format.limit:
            raise ValueError(
                f"the video would be {width}x{height}, but H.264 needs even sides up to {format.limit}; "
                f"choose another scale than {scale}"
            )
        self._movie: Movie | None = Movie(self.path, format, width, height, _check_rate(fps), sound=self.sound)

    def write(self, rgb: ByteArray, samples: ByteArray | None = None) -> None:
        """Append one screen and its sound.

        Args:
            rgb: the screen, (rows, columns, 3) uint8.
            samples: what `core.audio()` has after the frame, (512,) uint8; None is silence. Not looked at in a video
                without sound.

        Raises:
            TypeError, ValueError: not such arrays, or the video is closed.
            OSError: the disk is full, or the file cannot be written for another reason; the video is closed then.
        """
        if self._movie is None:
            raise ValueError(f"{self.path} is closed; make a new VideoWriter")
        _check_array("a screen", rgb, self._shape)
        if samples is not None and self.sound:
            _check_array("the sound of a screen", samples, (SAMPLES_PER_FRAME,))
        try:
            self._movie.write(rgb.repeat(self._scale, axis=0).repeat(2 * self._scale, axis=1), samples)
        except Exception:
            movie, self._movie = self._movie, None
            movie.close(broken=True)
            raise
        self.frames += 1

    def close(self) -> None:
        """Finish the file. Closing again does nothing."""
        movie, self._movie = self._movie, None
        if movie is not None:
            movie.close()

    def __enter__(self) -> "VideoWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _check_array(what: str, array: Any, shape: tuple[int, ...]) -> None:
    if not isinstance(array, np.ndarray) or array.dtype != np.uint8:
        kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
        raise TypeError(f"{what} is a uint8 array of shape {shape}, got {kind}")
    if array.shape != shape:
        raise ValueError(f"{what} of this video has shape {shape}, got {array.shape}")


def _check_rate(fps: Any) -> Fraction:
    if not isinstance(fps, Real):
        raise TypeError(f"fps is a number of screens a second, got {fps!r}")
    if not 0.001 <= float(fps) <= 1000:
        raise ValueError(f"fps must be within 0.001..1000, got {fps}")
    # MP4 counts time in 32-bit fractions of a second; the denominators of the console's rates are far below this one.
    return Fraction(fps if isinstance(fps, Rational) else float(fps)).limit_denominator(1_000_000)
