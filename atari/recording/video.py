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

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.cores.options import check_integer
from atari.game import Game

COLOUR_CLOCKS_PER_LINE = 228
COLOUR_CLOCK_HZ = MappingProxyType(
    {
        "NTSC": Fraction(315_000_000, 88),  # the colour subcarrier, 3.579545 MHz
        "PAL": Fraction(3_546_895),  # four fifths of the colour subcarrier, 4.43361875 MHz
        "SECAM": Fraction(228 * 15_625),  # the standard's 15,625 lines a second
    }
)
LINES_PER_FRAME = MappingProxyType({"NTSC": 262, "PAL": 312, "SECAM": 312})

# H.264's numbers for colours. The matrix is that of standard definition, which programs assume that do not look.
_BT709_PRIMARIES = _BT709_TRANSFER = 1
_BT601_MATRIX = 6
_LIMITED_RANGE = 1
_H264_LIMIT = 8192  # pixels a side that common decoders accept


def frame_rate(game: Game) -> Fraction:
    """Frames a second of the console that shows `game`: 59.92 with NTSC, 49.86 with PAL.

    Exact for a game that draws the lines of its TV format (262 or 312 of 228 colour clocks each), as nearly all do.
    Divide it by the frame skip for a video of one screen a step.
    """
    tv = game.screen.format
    return COLOUR_CLOCK_HZ[tv] / (COLOUR_CLOCKS_PER_LINE * LINES_PER_FRAME[tv])


class VideoWriter:
    """An MP4 file that grows by one screen with each `write`.

    Use it in a `with` statement, or call `close`; only then is the file complete. A writer that is closed without a
    screen leaves no file.

    Args:
        path: of the file, ending in ".mp4". Its folder is made, and a file of this name replaced.
        size: (rows, columns) of the screens, such as `game.screen.shape`.
        fps: screens a second, such as `frame_rate(game)`.
        scale: a pixel of the screen becomes `2 * scale` columns and `scale` rows of the video. H.264 stores
            colours for blocks of 2 x 2, so with an odd scale the colours of neighbouring rows mix at edges.
        pixel_aspect: (columns, rows) of a pixel at scale 1: (2, 1) on this console, (1, 1) for square pixels.

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
        pixel_aspect: tuple[int, int] = (2, 1),
    ) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() != ".mp4":
            raise ValueError(f"a video is an MP4 file, so its name must end in '.mp4', got {str(path)!r}")
        scale = check_integer("scale", scale, 1, 16)
        if not isinstance(size, (tuple, list)) or len(size) != 2:
            raise TypeError(f"size is (rows, columns) of the screens, got {size!r}")
        rows, columns = (check_integer("a side of size", side, 1, _H264_LIMIT) for side in size)
        self._shape = (rows, columns, 3)
        across, down = (check_integer("a side of pixel_aspect", side, 1, 16) for side in pixel_aspect)
        width, height = across * scale * columns, down * scale * rows
        if width % 2 or height % 2 or max(width, height) > _H264_LIMIT:
            raise ValueError(
                f"the video would be {width}x{height}, but H.264 needs even sides up to {_H264_LIMIT}; "
                f"choose another scale than {scale}"
            )
        rate = _check_rate(fps)
        av = _import_av()
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.open("wb").close()  # PyAV would find out that it cannot at the first screen only
        self._container = av.open(
            str(self.path),
            "w",
            format="mp4",
            options={"movflags": "hybrid_fragmented", "flush_packets": "1"},
        )
        self._stream = self._container.add_stream("libx264", rate=rate, options={"crf": "18", "preset": "veryfast"})
        self._stream.width, self._stream.height, self._stream.pix_fmt = width, height, "yuv420p"
        context = self._stream.codec_context
        context.color_range, context.colorspace = _LIMITED_RANGE, _BT601_MATRIX
        context.color_primaries, context.color_trc = _BT709_PRIMARIES, _BT709_TRANSFER
        self._new_frame = av.VideoFrame.from_ndarray

    def write(self, rgb: npt.NDArray[np.uint8]) -> None:
        """Append one screen, (rows, columns, 3) uint8.

        Raises:
            TypeError, ValueError: not such an array, or the video is closed.
            OSError: the disk is full, or the file cannot be written for another reason; the video is closed then.
        """
        if self._container is None:
            raise ValueError(f"{self.path} is closed; make a new VideoWriter")
        if not isinstance(rgb, np.ndarray) or rgb.dtype != np.uint8:
            kind = rgb.dtype if isinstance(rgb, np.ndarray) else type(rgb).__name__
            raise TypeError(f"a screen is a uint8 array of shape {self._shape}, got {kind}")
        if rgb.shape != self._shape:
            raise ValueError(f"a screen of this video has shape {self._shape}, got {rgb.shape}")
        frame = self._new_frame(np.ascontiguousarray(rgb), format="rgb24").reformat(
            self._stream.width,
            self._stream.height,
            "yuv420p",
            dst_colorspace="ITU601",
            interpolation="POINT",
        )
        frame.pts = self.frames
        try:
            self._container.mux(self._stream.encode(frame))
        except Exception:
            container, self._container = self._container, None
            container.close()  # and no more screens: FFmpeg may crash on what follows a failure
            raise
        self.frames += 1

    def close(self) -> None:
        """Finish the file. Closing again does nothing."""
        container, self._container = self._container, None
        if container is None:
            return
        try:
            if self.frames:
                container.mux(self._stream.encode(None))
        finally:
            container.close()
            if not self.frames:
                self.path.unlink()

    def __enter__(self) -> "VideoWriter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _check_rate(fps: Any) -> Fraction:
    if not isinstance(fps, Real):
        raise TypeError(f"fps is a number of screens a second, got {fps!r}")
    if not 0.001 <= float(fps) <= 1000:
        raise ValueError(f"fps must be within 0.001..1000, got {fps}")
    # MP4 counts time in 32-bit fractions of a second; the denominators of the console's rates are far below this one.
    return Fraction(fps if isinstance(fps, Rational) else float(fps)).limit_denominator(1_000_000)


def _import_av() -> Any:
    try:
        import av
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            "writing a video needs PyAV: pip install 'atari-envs[video]'"
        ) from None
    return av
