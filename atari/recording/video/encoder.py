"""The encoders of frames and sound: a file written by FFmpeg, or a sequence of PNG files."""

from contextlib import closing, suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

from atari.base import durable
from atari.base.extras import import_extra, install_extra
from atari.base.png import png
from atari.cores import ByteArray
from atari.recording.video.audio import AudioEncoder
from atari.recording.video.formats import is_picture
from atari.recording.video.images import Palette
from atari.recording.video.options import VideoOptions

# FFmpeg's colour constants. The matrix is standard definition's, because some programs assume it without reading it.
_BT709_PRIMARIES = _BT709_TRANSFER = 1
_BT601_MATRIX = 6
_LIMITED_RANGE = 1


class FFmpegEncoder:
    """A container of FFmpeg with a video stream and, with sound, an audio stream.

    The file gets its name when it has a second of frames, or when it is complete: an earlier file of the name stays
    until there is something in its place.

    Raises:
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
        OSError: the file cannot be written.
    """

    def __init__(self, options: VideoOptions, comment: str = "") -> None:
        self._path = path = options.path
        self._av = import_av()
        path.parent.mkdir(parents=True, exist_ok=True)
        part = durable.begin(path)  # PyAV reports an unwritable file only at the first frame, and follows links
        try:
            self._open(part, options, comment)
        except BaseException:
            durable.discard(path)
            raise

    def _open(self, part: Path, options: VideoOptions, comment: str) -> None:
        format, rate, av = options.format, options.rate, self._av
        container_options = dict(format.container_options)
        if format.container == "gif":  # without it, the last frame of slow motion would end at once
            container_options["final_delay"] = str(max(2, round(100 / rate)))
        self._container = av.open(f"file:{part}", "w", format=format.container, options=container_options)
        if comment:
            self._container.metadata["comment"] = comment
        self._rate = rate
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
        self._sound: AudioEncoder | None = None
        if options.sound and format.sound is not None:
            self._sound = AudioEncoder(av, self._container, format, rate)
        self._frames = 0
        self._last_tick = -1
        self._named = False

    def write(self, image: ByteArray, samples: ByteArray | None) -> None:
        """Append an image, (height, width, 3) or smaller for a format that enlarges, and its sound.

        Raises:
            OSError: the file cannot be written. The only valid call after that is `close(broken=True)`.
        """
        tick = int(self._frames * self._ticks_per_frame)
        self._frames += 1
        if tick > self._last_tick:
            frame = self._encodable(image)
            frame.pts = self._last_tick = tick
            self._container.mux(self._stream.encode(frame))
        if self._sound is not None:
            self._container.mux(self._sound.write(samples))
        if not self._named and self._frames > self._rate:
            with suppress(PermissionError):  # Windows does not rename an open file; `close` does
                durable.publish(self._path, lasting=False)
                self._named = True

    def _encodable(self, image: ByteArray) -> Any:
        if self._palette is not None:
            indices = self._palette.indices(image)
            return self._av.VideoFrame.from_ndarray((indices, self._palette.colours), format="pal8")
        stream = self._stream
        frame = self._av.VideoFrame.from_ndarray(image, format="rgb24")
        return frame.reformat(
            stream.width, stream.height, stream.pix_fmt, dst_colorspace="ITU601", interpolation="POINT"
        )

    def close(self, *, broken: bool = False) -> None:
        """Complete the file. A broken one is closed without flushing, because FFmpeg can crash after a failed write."""
        whole = self._frames > 0 and not broken
        try:
            with closing(self._container):
                if whole:
                    self._container.mux(self._stream.encode(None))
                    if self._sound is not None:
                        self._container.mux(self._sound.finish())
        except BaseException:
            durable.discard(self._path)
            raise
        if not whole:
            durable.discard(self._path)
        elif not self._named:
            durable.publish(self._path, lasting=False)


class PngEncoder:
    """Writes files "...000000.png", "...000001.png", ...; `path` has a placeholder for the number, such as "%06d".

    Without a placeholder, it writes one file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._frames = 0
        path.parent.mkdir(parents=True, exist_ok=True)

    def write(self, image: ByteArray, samples: ByteArray | None) -> None:
        """Write the next file."""
        path = self._path if is_picture(self._path) else self._path.with_name(self._path.name % self._frames)
        durable.write_file(path, png(image), lasting=False)  # waiting for the disk would take longer than the frame
        self._frames += 1

    def close(self, *, broken: bool = False) -> None:
        """Do nothing: each file is complete when it is written."""


def import_av(doing: str = "writing") -> Any:
    """Return the module PyAV, or raise as `import_extra`."""
    return import_extra("av", f"{doing} a video needs PyAV: {install_extra('video')}")
