"""`VideoRecorder`: write the frames of an environment to a video."""

import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from atari.base import durable
from atari.classic import error
from atari.recording import VideoWriter

_SMALL = 300  # rows; smaller frames are doubled, to keep their colours sharp
_SECONDS_OF_A_TEXT = 0.5


class Renderable(Protocol):
    """The part of an environment that a video needs."""

    metadata: dict[str, Any]

    def render(self, mode: str = "human") -> Any:
        """The frame, (rows, columns, 3) uint8, for mode "rgb_array"; a text for mode "ansi"."""


class VideoRecorder:
    """Writes a video, `path`, and its description, with the ending `.meta.json`.

    An environment that renders texts alone, by its metadata, is recorded as texts, in a JSON file in asciinema's format
    1. A video without frames leaves no file.

    Args:
        env: an environment that renders "rgb_array" or "ansi".
        path: the file of the video, with the ending `.mp4`, or `.json` for texts; without `path` and `base_path`, a
            file in a new temporary folder.
        metadata: more fields of the description.
        enabled: False writes nothing.
        base_path: `path` without its ending, instead of `path`.

    Attributes:
        enabled: whether the environment is recorded.
        functional: whether it is recorded, and no frame failed.
        last_frame: the last frame; None before the first.
        frames_per_sec, output_frames_per_sec: the rate, from the environment's metadata.

    Raises:
        gymnasium.error.Error: both `path` and `base_path` are given, or `path` has another ending; from
            `capture_frame`: the environment returned no frame.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`), from the first `capture_frame`.
    """

    def __init__(
        self,
        env: Renderable,
        path: str | os.PathLike[str] | None = None,
        metadata: dict[str, Any] | None = None,
        enabled: bool = True,
        base_path: str | os.PathLike[str] | None = None,
    ) -> None:
        if path is not None and base_path is not None:
            raise PathError(f"give either path or base_path, got path={path!r} and base_path={base_path!r}")
        modes = env.metadata.get("render.modes", [])
        self.env = env
        self.ansi_mode = "ansi" in modes and "rgb_array" not in modes
        self.render_mode = "ansi" if self.ansi_mode else "rgb_array"
        self.enabled = enabled
        ending = ".json" if self.ansi_mode else ".mp4"
        if path is None:
            path = f"{os.path.join(tempfile.mkdtemp(), 'video') if base_path is None else os.fspath(base_path)}{ending}"
        self.path = os.fspath(path)
        if not self.path.endswith(ending):
            what = (
                "this environment renders texts, which are recorded as JSON"
                if self.ansi_mode
                else "videos are MP4 files"
            )
            raise PathError(f"{what}, so path ends with {ending}, got {self.path!r}")
        self.metadata_path = f"{os.path.splitext(self.path)[0]}.meta.json"
        self.frames_per_sec = env.metadata.get("video.frames_per_second", 30)
        self.output_frames_per_sec = env.metadata.get("video.output_frames_per_second", self.frames_per_sec)
        self.last_frame: Any = None
        self.encoder: ImageEncoder | TextEncoder | None = None
        self.broken, self.empty = False, True
        self.metadata = {
            **(metadata or {}),
            "content_type": "video/vnd.openai.ansivid" if self.ansi_mode else "video/mp4",
        }
        self.render_history: list[Any] = []  # the frames between two steps, of which this interface renders none
        self._closed = False

    @property
    def functional(self) -> bool:
        """Whether the environment is recorded, and no frame failed."""
        return self.enabled and not self.broken

    def capture_frame(self) -> None:
        """Add the present frame of the environment."""
        if not self.functional or self._closed:
            return
        frame = self.env.render(mode=self.render_mode)
        if frame is None:
            if self.env.metadata.get("semantics.async"):
                return
            what = "text" if self.ansi_mode else "image"
            raise error.Error(f"render(mode={self.render_mode!r}) of {self.env} returned nothing; return the {what}")
        self.last_frame = frame
        if self.ansi_mode:
            self._encode_ansi_frame(frame)
        else:
            self._encode_image_frame(frame)

    def close(self) -> None:
        """Write the rest of the video; later calls do nothing."""
        if not self.enabled or self._closed:
            return
        self._closed = True
        if self.encoder is not None:
            self.encoder.close()
            self.encoder = None
            self.write_metadata()

    def write_metadata(self) -> None:
        """Write the description."""
        durable.write_file(Path(self.metadata_path), json.dumps(self.metadata).encode())

    def _encode_ansi_frame(self, frame: Any) -> None:
        if self.encoder is None:
            self._begin(TextEncoder(self.path, self.frames_per_sec))
        self._add(frame)

    def _encode_image_frame(self, frame: Any) -> None:
        if self.encoder is None:
            aspect = self.env.metadata.get("video.pixel_aspect", (1, 1))
            shape = np.shape(frame)
            self._begin(ImageEncoder(self.path, shape, self.frames_per_sec, self.output_frames_per_sec, aspect))
        self._add(frame)

    def _begin(self, encoder: "ImageEncoder | TextEncoder") -> None:
        self.encoder = encoder
        self.metadata["frames_per_second"] = float(self.frames_per_sec)
        self.metadata["encoder_version"] = encoder.version_info
        try:
            self.write_metadata()
        except BaseException:
            self.encoder = None
            if isinstance(encoder, ImageEncoder):
                encoder.close()  # a video without a frame leaves no file
            raise

    def _add(self, frame: Any) -> None:
        assert self.encoder is not None
        try:
            self.encoder.capture_frame(frame)
        except error.InvalidFrame:
            self.broken = True
            raise
        self.empty = False

    def __del__(self) -> None:
        if "_closed" in vars(self):
            self.close()


class PathError(error.Error, ValueError):
    """The path of a video is wrong."""


class ImageEncoder:
    """Writes images to a video, by PyAV.

    Args:
        output_path: the file of the video.
        frame_shape: the shape of the images, (rows, columns, 3), or 4 with transparency, which is not shown.
        frames_per_sec: the rate of the images.
        output_frames_per_sec: has no effect; the video has each image once.
        pixel_aspect: columns and rows of the video for a pixel of an image.

    Raises:
        gym.error.InvalidFrame: the shape is another one; from `capture_frame`: the image has another shape or
            dtype.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`).
    """

    def __init__(
        self,
        output_path: str | os.PathLike[str],
        frame_shape: tuple[int, ...],
        frames_per_sec: float,
        output_frames_per_sec: float | None = None,
        pixel_aspect: tuple[int, int] = (1, 1),
    ) -> None:
        if len(frame_shape) != 3 or frame_shape[2] not in (3, 4):
            raise error.InvalidFrame(
                f"an image has the shape (rows, columns, 3), or 4 with transparency, got {frame_shape}"
            )
        self.output_path = output_path
        self.frame_shape = frame_shape
        rows, columns, colours = frame_shape
        self.wh = columns, rows
        self.includes_alpha = colours == 4
        self.frames_per_sec = frames_per_sec
        self.output_frames_per_sec = output_frames_per_sec or frames_per_sec
        self.backend = "PyAV"
        self._aspect = pixel_aspect
        self.start()

    @property
    def version_info(self) -> dict[str, Any]:
        """The program that encodes, and its version."""
        import av

        return {"backend": self.backend, "version": av.__version__}

    def start(self) -> None:
        """Open the file."""
        columns, rows = self.wh
        scale = 2 if rows < _SMALL or rows % 2 or columns % 2 else 1
        path = Path(self.output_path)
        self.proc = VideoWriter(path, (rows, columns), self.frames_per_sec, scale=scale, pixel_aspect=self._aspect)

    def capture_frame(self, frame: Any) -> None:
        """Add an image."""
        if not isinstance(frame, np.ndarray) or frame.shape != self.frame_shape or frame.dtype != np.uint8:
            found = f"{frame.dtype} {frame.shape}" if isinstance(frame, np.ndarray) else repr(frame)
            raise error.InvalidFrame(f"the images of this video are arrays of uint8 {self.frame_shape}, got {found}")
        self.proc.write(frame[..., :3])

    def close(self) -> None:
        """Complete the file."""
        self.proc.close()


class TextEncoder:
    """Writes texts to a JSON file in asciinema's format 1, which shows each for half a second.

    Args:
        output_path: the file.
        frames_per_sec: has no effect.

    Raises:
        gym.error.InvalidFrame: from `capture_frame`: it is no text, or does not end with a newline.
    """

    def __init__(self, output_path: str | os.PathLike[str], frames_per_sec: float) -> None:
        self.output_path = output_path
        self.frames_per_sec = frames_per_sec
        self.frames: list[str] = []

    @property
    def version_info(self) -> dict[str, Any]:
        """The program that encodes, and its version."""
        return {"backend": "TextEncoder", "version": 1}

    def capture_frame(self, frame: Any) -> None:
        """Add a text, or a `StringIO` with one."""
        text = frame.getvalue() if isinstance(frame, io.StringIO) else frame
        if not isinstance(text, str) or not text.endswith("\n") or "\r" in text:
            raise error.InvalidFrame(f"a frame is a text whose lines end with newlines, the last too, got {text!r}")
        self.frames.append(text)

    def close(self) -> None:
        """Write the file."""
        clear = "\x1b[2J\x1b[1;1H"
        lines = [frame.split("\n") for frame in self.frames]
        data = {
            "version": 1,
            "width": max((len(line) for frame in lines for line in frame), default=0) + 2,
            "height": max((len(frame) for frame in lines), default=1),
            "duration": len(self.frames) * _SECONDS_OF_A_TEXT,
            "command": "-",
            "title": "gym VideoRecorder episode",
            "env": {},
            "stdout": [(_SECONDS_OF_A_TEXT, clear + frame.replace("\n", "\r\n")) for frame in self.frames],
        }
        durable.write_file(Path(self.output_path), json.dumps(data).encode())


def touch(path: str | os.PathLike[str]) -> None:
    """Make an empty file if there is none."""
    Path(path).touch()
