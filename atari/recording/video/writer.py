"""`VideoWriter`: writes frames and their sound to a video file, frame by frame.

A video looks as the console did on a television. The console's pixels are about twice as wide as high, so each
becomes a block of 2 x 1 times an integer scale, without blur. The frame rate is exact: it follows from the console's
colour clock. A frame's sound lasts exactly as long as the frame.

FFmpeg encodes, inside PyAV (extra `video`). `formats.py` has the formats.
"""

import errno
import os
from contextlib import suppress
from fractions import Fraction
from numbers import Rational, Real
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from atari.base.frozen import FrozenDict
from atari.cores import ByteArray
from atari.games.game import Game
from atari.recording.video.audio import SAMPLES_PER_FRAME
from atari.recording.video.encoder import FFmpegEncoder, PngEncoder
from atari.recording.video.formats import is_picture
from atari.recording.video.images import add_caption, enlarge
from atari.recording.video.options import VideoOptions

COLOUR_CLOCKS_PER_LINE = 228
COLOUR_CLOCK_HZ = FrozenDict(
    {
        "NTSC": Fraction(315_000_000, 88),  # the colour subcarrier, 3.579545 MHz
        "PAL": Fraction(3_546_895),  # four fifths of the colour subcarrier, 4.43361875 MHz
        "SECAM": Fraction(228 * 15_625),  # the standard's 15,625 lines a second
    }
)
SPEEDS = (0.05, 16)
"""The least and the greatest speed of a video. FLAC has no sample rate for a greater one."""
LINES_PER_FRAME = FrozenDict({"NTSC": 262, "PAL": 312, "SECAM": 312})


def frame_rate(game: Game) -> Fraction:
    """The console's frames a second for `game`: 59.92 with NTSC, 49.86 with PAL.

    It is exact for a game that draws the lines of its TV format (262 or 312 of 228 colour clocks each).
    """
    tv = game.screen.format
    return COLOUR_CLOCK_HZ[tv] / (COLOUR_CLOCKS_PER_LINE * LINES_PER_FRAME[tv])


def video_rate(game: Game, suffix: str, fps: Any = None, speed: Any = 1) -> Any:
    """The frames a second of a video: `fps`, or without it the console's rate times `speed`.

    Args:
        game: the game that is shown.
        suffix: the suffix of the video, such as ".mp4".
        fps, speed: see `VideoWriter`.

    Raises:
        TypeError, ValueError: `speed` is no number within `SPEEDS`, is given with `fps`, or the format has no speed.
    """
    if isinstance(speed, bool) or not isinstance(speed, Real):
        raise TypeError(f"speed is a number, such as 0.5 for half the console's speed, got {speed!r}")
    if not SPEEDS[0] <= float(speed) <= SPEEDS[1]:
        raise ValueError(f"speed must be within {SPEEDS[0]}..{SPEEDS[1]}, where 1 is the console's speed, got {speed}")
    if speed == 1:
        return frame_rate(game) if fps is None else fps
    if fps is not None:
        raise ValueError(f"fps={fps} and speed={speed} both decide how fast a video is; leave one out")
    if suffix.lower() == ".png":
        raise ValueError(f"a PNG has no speed, got speed={speed}; leave it out, or write another format")
    return frame_rate(game) * Fraction(speed if isinstance(speed, Rational) else float(speed)).limit_denominator(1000)


class VideoWriter:
    """A video file that grows by one frame, with its sound, at each `write`.

    Use it in a `with` statement, or call `close`, which completes the file. A writer that is closed without a frame
    leaves no file. If the process is killed, the file plays up to its last second. It has its name when a second of it
    is written, and is named NAME.part before.

    The suffix of the file name chooses the format:

    ======= ===================== ===============================================================================
    .mp4    H.264, AAC            plays nearly everywhere
    .mkv    FFV1, FLAC            lossless: pixels as written, samples as `(samples - 128) * 128`
    .webm   VP9, Opus             for web pages
    .gif    exact colours, silent at most 50 frames a second; from 59.92, one frame in six is dropped
    .png    lossless, silent      a file a frame; the name has a placeholder for the number, such as "pong/%06d.png".
                                  A name without a placeholder is one picture, and takes one frame
    ======= ===================== ===============================================================================

    Args:
        path: the file. Its folder is created, and a file of this name replaced.
        size: the `Game` whose frames are written, or (rows, columns) of the frames.
        fps: frames a second; None is the console's rate for a `Game`, 59.92 with NTSC and 49.86 with PAL. Divide that
            by the frame skip for a video of one frame a step.
        speed: the speed of the video of a `Game`, within 0.05..16: 0.25 is slow motion, and 4 is fast. The video has
            all frames. Their sound lasts as long as they do: it is lower in slow motion, and higher in a fast video.
        scale: a pixel of the frame becomes `2 * scale` columns and `scale` rows of the video. MP4 and WebM store
            colours for blocks of 2 x 2, so with an odd scale the colours of neighbouring rows mix at edges.
        pixel_aspect: (columns, rows) of a pixel at scale 1: (2, 1) on this console; other environments have (1, 1).
        sound: whether the video has a sound track. A frame's samples last as long as the frame, so `fps` must be the
            rate of emulated frames, not of steps.
        caption_lines: lines of text below the frame, `8 * scale` rows each, for the captions passed to `write`.
        comment: a text in the metadata of the file, from which `video_facts` reads; GIF and PNG have none.

    Attributes:
        path: the file.
        fps: frames a second, a `Fraction`.
        sound: whether the video has a sound track.

    Raises:
        TypeError, ValueError: an argument has the wrong type or is out of range.
        OSError: the file cannot be written.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.

    Example:
        >>> import atari
        >>> from atari.recording import VideoWriter
        >>> core = atari.cores.NativeCore("pong", seed=0)
        >>> core.reset()
        >>> with VideoWriter("pong.gif", core.game) as writer:
        ...     for _ in range(10):
        ...         reward = core.act(2)
        ...         writer.write(core.screen_rgb())
        >>> writer.frames, round(float(writer.fps), 2)
        (10, 59.92)
    """

    frames: int = 0
    """Frames written so far."""

    def __init__(
        self,
        path: str | PathLike[str],
        size: Game | tuple[int, int],
        fps: Fraction | float | None = None,
        *,
        speed: float = 1,
        scale: int = 2,
        pixel_aspect: tuple[int, int] = (2, 1),
        sound: bool = False,
        caption_lines: int = 0,
        comment: str = "",
    ) -> None:
        if isinstance(size, Game):
            fps = video_rate(size, Path(path).suffix, fps, speed)
            size = size.screen.shape
        elif speed != 1:
            raise ValueError(f"speed={speed} is for a Game, whose frame rate is known; multiply fps by it instead")
        options = VideoOptions.check(
            path, size, fps, scale=scale, pixel_aspect=pixel_aspect, sound=sound, caption_lines=caption_lines
        )
        self._options = options
        self.path, self.fps, self.sound = options.path, options.rate, options.sound
        self._encoder: FFmpegEncoder | PngEncoder | None = (
            FFmpegEncoder(options, comment) if options.format.container else PngEncoder(self.path)
        )

    def write(self, rgb: ByteArray, samples: ByteArray | None = None, caption: str = "") -> None:
        """Append a frame and its sound.

        Args:
            rgb: the frame, (rows, columns, 3) uint8.
            samples: `core.audio()` after the frame, (512,) uint8; None is silence. Ignored in a video without sound.
            caption: text below the frame, up to `caption_lines` lines.

        Raises:
            TypeError, ValueError: an array has another shape or dtype, the video is closed, it has no line for the
                caption, or the file is one picture and has a frame.
            OSError: the file cannot be written, for example because the disk is full. The video is then closed.
        """
        if self._encoder is None:
            raise ValueError(f"{self.path} is closed; make a new VideoWriter")
        if self.frames and is_picture(self.path):
            raise ValueError(
                f"{self.path} is one picture, and has its frame; name a picture of each frame such as 'pong/%06d.png'"
            )
        _check_array("a screen", rgb, self._options.shape)
        if samples is not None and self.sound:
            _check_array("the sound of a screen", samples, (SAMPLES_PER_FRAME,))
        scale, lines = self._options.scale, self._options.caption_lines
        if caption and not lines:
            raise ValueError(
                f"a caption needs lines of text: make the VideoWriter with caption_lines=1, got {caption!r}"
            )
        image = np.ascontiguousarray(rgb)
        if lines or not self._options.format.enlarges:
            image = enlarge(image, *(scale * side for side in self._options.pixel_aspect))
        if lines:
            image = add_caption(image, caption, lines, scale)
        try:
            self._encoder.write(image, samples)
        except Exception as error:
            encoder, self._encoder = self._encoder, None
            with suppress(OSError):  # closing meets the same error
                encoder.close(broken=True)
            raise self._incomplete(error) from error
        self.frames += 1

    def close(self) -> None:
        """Complete the file. A second call does nothing.

        Raises:
            OSError: the rest of the file cannot be written.
        """
        encoder, self._encoder = self._encoder, None
        if encoder is None:
            return
        try:
            encoder.close()
        except OSError as error:
            raise self._incomplete(error) from error

    def __getstate__(self) -> dict[str, Any]:
        raise TypeError(f"VideoWriter writes {self.path} and cannot be copied or pickled; make a new one")

    def _incomplete(self, error: Exception) -> Exception:
        """`error`; an OSError gets the name of the file and the number of frames in it."""
        if not isinstance(error, OSError):
            return error
        number = error.errno or errno.EIO
        return OSError(
            number, f"{error.strerror or os.strerror(number)}; incomplete, after {self.frames:,} frames", str(self.path)
        )

    def __enter__(self) -> "VideoWriter":
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def _check_array(what: str, array: Any, shape: tuple[int, ...]) -> None:
    if not isinstance(array, np.ndarray) or array.dtype != np.uint8:
        kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
        raise TypeError(f"{what} is a uint8 array of shape {shape}, got {kind}")
    if array.shape != shape:
        raise ValueError(f"{what} of this video has shape {shape}, got {array.shape}")
