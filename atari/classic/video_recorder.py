"""`VideoRecorder`: write the frames of an environment to a video."""

import json
import os
import tempfile
from pathlib import Path
from typing import Any, Protocol

import gymnasium

from atari.files import durable
from atari.recording import VideoWriter

_SMALL = 300  # rows; smaller frames are doubled, to keep their colours sharp


class Renderable(Protocol):
    """The part of an environment that a video needs."""

    metadata: dict[str, Any]

    def render(self, mode: str = "human") -> Any:
        """The frame, (rows, columns, 3) uint8, for mode "rgb_array"."""


class VideoRecorder:
    """Writes a video, `path`, and its description, with the ending `.meta.json`.

    Args:
        env: an environment that renders "rgb_array".
        path: the file of the video, with the ending `.mp4`; without `path` and `base_path`, a file in a new temporary
            folder.
        metadata: more fields of the description.
        enabled: False writes nothing.
        base_path: `path` without its ending, instead of `path`.

    Raises:
        ValueError: both `path` and `base_path` are given, or `path` has another ending.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`), from the first `capture_frame`.
        gymnasium.error.Error: the environment returned no frame, from `capture_frame`.
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
            raise ValueError(f"give either path or base_path, got path={path!r} and base_path={base_path!r}")
        if path is None:
            path = f"{os.path.join(tempfile.mkdtemp(), 'video') if base_path is None else os.fspath(base_path)}.mp4"
        path = os.fspath(path)
        if not path.endswith(".mp4"):
            raise ValueError(f"videos are MP4 files, so path ends with .mp4, got {path!r}")
        self.path = path
        self.enabled = enabled
        self._env = env
        self._metadata = {"content_type": "video/mp4", **(metadata or {})}
        self._video: VideoWriter | None = None

    def capture_frame(self) -> None:
        """Add the present frame of the environment."""
        if not self.enabled:
            return
        frame = self._env.render(mode="rgb_array")
        if frame is None:
            raise gymnasium.error.Error(f"render(mode='rgb_array') of {self._env} returned nothing; return the image")
        if self._video is None:
            self._video = self._begin(*frame.shape[:2])
        self._video.write(frame)

    def close(self) -> None:
        """Write the rest of the video; later calls do nothing."""
        video, self._video = self._video, None
        if video is not None:
            video.close()

    def _begin(self, rows: int, columns: int) -> VideoWriter:
        rate = self._env.metadata.get("video.frames_per_second", 30)
        video = VideoWriter(
            Path(self.path),
            (rows, columns),
            rate,
            scale=2 if rows < _SMALL or rows % 2 or columns % 2 else 1,
            pixel_aspect=self._env.metadata.get("video.pixel_aspect", (1, 1)),
        )
        facts = {**self._metadata, "frames_per_second": float(rate)}
        durable.write_file(Path(self.path).with_suffix(".meta.json"), json.dumps(facts).encode())
        return video
