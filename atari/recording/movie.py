"""Where pictures and sound go: a file that FFmpeg writes, or a sequence of PNG files."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import gymnasium

from atari.cores import ByteArray
from atari.recording.audio import SoundTrack
from atari.recording.options import VideoOptions
from atari.recording.pictures import Palette

# FFmpeg's numbers for colours. The matrix is that of standard definition, which programs assume that do not look.
_BT709_PRIMARIES = _BT709_TRANSFER = 1
_BT601_MATRIX = 6
_LIMITED_RANGE = 1


class Movie:
    """A container of FFmpeg's with a stream of pictures and perhaps one of sound.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
        OSError: the file cannot be written.
    """

    def __init__(self, options: VideoOptions) -> None:
        format, rate = options.format, options.rate
        self._path = path = options.path
        self._av = av = import_av()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("wb").close()  # PyAV would find out that it cannot at the first picture only
        self._container = av.open(f"file:{path}", "w", format=format.container, options=dict(format.container_options))
        shown = rate if format.max_rate is None else Fraction(format.max_rate)
        self._ticks_per_frame = shown / rate
        self._stream = self._container.add_stream(format.codec, rate=shown, options=dict(format.codec_options))
        self._stream.width, self._stream.height = options.width, options.height
        self._stream.pix_fmt = format.pixels
        if format.pixels == "yuv420p":
            context = self._stream.codec_context
            context.color_range, context.colorspace = _LIMITED_RANGE, _BT601_MATRIX
            context.color_primaries, context.color_trc = _BT709_PRIMARIES, _BT709_TRANSFER
        self._palette = Palette() if format.pixels == "pal8" else None
        self._sound: SoundTrack | None = None
        if options.sound and format.sound is not None:
            self._sound = SoundTrack(av, self._container, format, rate)
        self._frames = 0
        self._last_tick = -1

    def write(self, picture: ByteArray, samples: ByteArray | None) -> None:
        """Append a picture, (height, width, 3) or smaller for a format that enlarges, and its sound.

        Raises:
            OSError: the file cannot be written; do not write to it again, but close it as broken.
        """
        tick = int(self._frames * self._ticks_per_frame)
        self._frames += 1
        if tick > self._last_tick:
            frame = self._encodable(picture)
            frame.pts = self._last_tick = tick
            self._container.mux(self._stream.encode(frame))
        if self._sound is not None:
            self._container.mux(self._sound.write(samples))

    def _encodable(self, picture: ByteArray) -> Any:
        if self._palette is not None:
            numbers = self._palette.numbers(picture)
            return self._av.VideoFrame.from_ndarray((numbers, self._palette.colours), format="pal8")
        stream = self._stream
        frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
        return frame.reformat(
            stream.width, stream.height, stream.pix_fmt, dst_colorspace="ITU601", interpolation="POINT"
        )

    def close(self, *, broken: bool = False) -> None:
        """Complete the file; a broken one is only closed, as FFmpeg may crash on what follows a failure."""
        try:
            if self._frames and not broken:
                self._container.mux(self._stream.encode(None))
                if self._sound is not None:
                    self._container.mux(self._sound.finish())
        finally:
            self._container.close()
            if not self._frames:
                self._path.unlink()


class PngSequence:
    """Files "...000000.png", "...000001.png", ...: `path` holds a number's place, such as "%06d"."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._frames = 0
        path.parent.mkdir(parents=True, exist_ok=True)

    def write(self, picture: ByteArray, samples: ByteArray | None) -> None:
        """Write the next file."""
        _, data = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
        self._path.with_name(self._path.name % self._frames).write_bytes(data.tobytes())
        self._frames += 1

    def close(self, *, broken: bool = False) -> None:
        """Each file is complete already."""


def import_av() -> Any:
    """The module `av`.

    Raises:
        gymnasium.error.DependencyNotInstalled: it is not installed.
    """
    try:
        import av
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            "writing a video needs PyAV: pip install 'atari-envs[video]'"
        ) from None
    return av
