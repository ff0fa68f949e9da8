"""`Movie`: a file that PyAV writes, of pictures and sound that arrive a frame at a time."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from atari.cores import ByteArray
from atari.recording.audio import SoundTrack
from atari.recording.formats import Format

# H.264's numbers for colours. The matrix is that of standard definition, which programs assume that do not look.
_BT709_PRIMARIES = _BT709_TRANSFER = 1
_BT601_MATRIX = 6
_LIMITED_RANGE = 1


class Movie:
    """A container of FFmpeg's with a stream of pictures and perhaps one of sound.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
        OSError: the file cannot be written.
    """

    def __init__(self, path: Path, format: Format, width: int, height: int, rate: Fraction, *, sound: bool) -> None:
        self._path = path
        self._av = av = _import_av()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("wb").close()  # PyAV would find out that it cannot at the first picture only
        self._container = av.open(str(path), "w", format=format.container, options=dict(format.container_options))
        self._pictures = self._container.add_stream(format.codec, rate=rate, options=dict(format.codec_options))
        self._pictures.width, self._pictures.height, self._pictures.pix_fmt = width, height, format.pixels
        context = self._pictures.codec_context
        context.color_range, context.colorspace = _LIMITED_RANGE, _BT601_MATRIX
        context.color_primaries, context.color_trc = _BT709_PRIMARIES, _BT709_TRANSFER
        self._sound: SoundTrack | None = None
        if sound:
            stream = self._container.add_stream(format.sound, rate=format.sound_rate, layout="mono")
            self._sound = SoundTrack(av, stream, rate)
        self._frames = 0

    def write(self, picture: ByteArray, samples: ByteArray | None) -> None:
        """Append a picture (height, width, 3) and its sound.

        Raises:
            OSError: the file cannot be written; do not write to it again, but close it.
        """
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24").reformat(
            format=self._pictures.pix_fmt, dst_colorspace="ITU601", interpolation="POINT"
        )
        frame.pts = self._frames
        self._container.mux(self._pictures.encode(frame))
        if self._sound is not None:
            self._container.mux(self._sound.write(samples))
        self._frames += 1

    def close(self, *, broken: bool = False) -> None:
        """Complete the file; a broken one is only closed, as FFmpeg may crash on what follows a failure."""
        try:
            if self._frames and not broken:
                self._container.mux(self._pictures.encode(None))
                if self._sound is not None:
                    self._container.mux(self._sound.finish())
        finally:
            self._container.close()
            if not self._frames:
                self._path.unlink()


def _import_av() -> Any:
    try:
        import av
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled(
            "writing a video needs PyAV: pip install 'atari-envs[video]'"
        ) from None
    return av
