"""`VideoWriter`: screens and sound in, a video file out, frame by frame, and out to the disk.

A video is right when it looks, moves and sounds as the console did on a television. The console's pixels are about
twice as wide as high, so each becomes a block of 2 x 1 times an integer scale: no pixel is blurred, none is wider than
its neighbour. The console's frame rate is no round number; it follows from the clock that draws the colours. And a
frame's sound lasts exactly as long as the frame.

The encoders are FFmpeg's, inside PyAV (extra `video`). `formats.py` has the kinds of files.
"""

from fractions import Fraction
from os import PathLike
from types import MappingProxyType, TracebackType
from typing import Any

import numpy as np

from atari.cores import ByteArray
from atari.game import Game
from atari.recording.audio import SAMPLES_PER_FRAME
from atari.recording.movie import Movie, PngSequence
from atari.recording.options import VideoOptions
from atari.recording.pictures import add_caption, enlarge

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
    screen leaves no file. What a killed process has written plays, up to its last second.

    The ending of the file's name chooses the format:

    ======= ===================== ===============================================================================
    .mp4    H.264, AAC            plays nearly everywhere
    .mkv    FFV1, FLAC            lossless: pixels and samples as they were written, `(samples - 128) * 128`
    .webm   VP9, Opus             for pages
    .gif    exact colours, silent 50 pictures a second at most; of 59.92, one in six is left out
    .png    lossless, silent      a file a screen; the name has a place for the number, such as "pong/%06d.png"
    ======= ===================== ===============================================================================

    Args:
        path: of the file. Its folder is made, and a file of this name replaced.
        size: (rows, columns) of the screens, such as `game.screen.shape`.
        fps: screens a second, such as `frame_rate(game)`.
        scale: a pixel of the screen becomes `2 * scale` columns and `scale` rows of the video. MP4 and WebM store
            colours for blocks of 2 x 2, so with an odd scale the colours of neighbouring rows mix at edges.
        pixel_aspect: (columns, rows) of a pixel at scale 1: (2, 1) on this console; other environments have (1, 1).
        sound: the video has a sound track. Each screen's samples last as long as the screen, so `fps` must be that
            of emulated frames, not of steps.
        caption_lines: lines of text beneath the picture, `8 * scale` rows each, for the captions given to `write`.

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
        sound: bool = False,
        caption_lines: int = 0,
    ) -> None:
        options = VideoOptions.check(
            path, size, fps, scale=scale, pixel_aspect=pixel_aspect, sound=sound, caption_lines=caption_lines
        )
        self._options = options
        self.path = options.path
        self.sound = options.sound
        self._sink: Movie | PngSequence | None = Movie(options) if options.format.container else PngSequence(self.path)

    def write(self, rgb: ByteArray, samples: ByteArray | None = None, caption: str = "") -> None:
        """Append one screen and its sound.

        Args:
            rgb: the screen, (rows, columns, 3) uint8.
            samples: what `core.audio()` has after the frame, (512,) uint8; None is silence. Not looked at in a video
                without sound.
            caption: text beneath the picture, up to `caption_lines` lines.

        Raises:
            TypeError, ValueError: not such arrays, or the video is closed.
            OSError: the disk is full, or the file cannot be written for another reason; the video is closed then.
        """
        if self._sink is None:
            raise ValueError(f"{self.path} is closed; make a new VideoWriter")
        _check_array("a screen", rgb, self._options.shape)
        if samples is not None and self.sound:
            _check_array("the sound of a screen", samples, (SAMPLES_PER_FRAME,))
        scale, lines = self._options.scale, self._options.caption_lines
        picture = np.ascontiguousarray(rgb)
        if lines or not self._options.format.enlarges:
            picture = enlarge(picture, *(scale * side for side in self._options.pixel_aspect))
        if lines:
            picture = add_caption(picture, caption, lines, scale)
        try:
            self._sink.write(picture, samples)
        except Exception:
            sink, self._sink = self._sink, None
            sink.close(broken=True)
            raise
        self.frames += 1

    def close(self) -> None:
        """Finish the file. Closing again does nothing."""
        sink, self._sink = self._sink, None
        if sink is not None:
            sink.close()

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
