"""`VideoRecorder`: writes the frames of a core to video files, and defers the errors of writing."""

import errno
import json
import os
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

from atari.base.validation import check_name
from atari.cores import ByteArray, Core
from atari.recording.recorders import DeferredErrorMixin
from atari.recording.video.encoder import import_av
from atari.recording.video.facts import facts_of
from atari.recording.video.formats import FORMATS
from atari.recording.video.options import VideoOptions
from atari.recording.video.overlay import Overlay
from atari.recording.video.writer import VideoWriter
from atari.task import Task


class VideoSettings:
    """The settings of all videos of a wrapper, see `RecordVideo`; `size` is (rows, columns) of the frames.

    Raises:
        TypeError, ValueError: an argument has the wrong type or is out of range.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
    """

    def __init__(
        self,
        format: str,
        size: tuple[int, int],
        fps: Fraction | float,
        scale: int,
        sound: bool,
        overlay: tuple[str, ...] | None,
        keep: str,
    ) -> None:
        check_name("format", format, [suffix[1:] for suffix in FORMATS])
        check_name("keep", keep, ["all", "best"])
        self.keep = keep
        self.overlay = Overlay(overlay)
        self.format, self.size, self.fps, self.scale = format, self.overlay.size(size), fps, scale
        self.sound = bool(sound) and FORMATS[f".{format}"].sound is not None
        VideoOptions.check(self.path("", "x"), self.size, fps, **self._options())
        if FORMATS[f".{format}"].container:
            import_av()

    def set_fps(self, fps: float) -> None:
        """Set the frames a second of the videos that begin from now on.

        Raises:
            TypeError, ValueError: it is no number, or out of range.
        """
        VideoOptions.check(self.path("", "x"), self.size, fps, **self._options())
        self.fps = fps

    def _options(self) -> dict[str, Any]:
        return {"scale": self.scale, "sound": self.sound, "caption_lines": self.overlay.caption_lines}

    def path(self, folder: str | os.PathLike[str], name: str) -> Path:
        """Return the path of a video of this name."""
        return Path(folder, name, "%06d.png") if self.format == "png" else Path(folder, f"{name}.{self.format}")

    def writer(self, path: Path, comment: str) -> VideoWriter:
        """Open a new file."""
        return VideoWriter(path, self.size, self.fps, comment=comment, **self._options())


class VideoRecorder(DeferredErrorMixin):
    """The writer of the frames of an environment's core. It owns the open video file, at most one."""

    def __init__(self, settings: VideoSettings, task: Callable[[], Task]) -> None:
        self._settings, self._task = settings, task
        self._writer: VideoWriter | None = None
        self._overlay = Overlay(settings.overlay.parts)
        self.score = 0
        """The sum of the rewards in the current video, or in the last one."""

    @property
    def recording(self) -> bool:
        """Whether a video is being written."""
        return self._writer is not None

    @property
    def frames(self) -> int:
        """Frames in the current video; 0 without one."""
        return 0 if self._writer is None else self._writer.frames

    @property
    def path(self) -> Path | None:
        """The file of the current video; None without one."""
        return None if self._writer is None else self._writer.path

    def start(self, path: Path) -> None:
        """Begin a video of the task that is played now.

        Raises:
            OSError: the file cannot be written.
        """
        self._writer = self._settings.writer(path, json.dumps(facts_of(self._task())))
        self.score = 0

    def stop(self) -> None:
        """Complete the video.

        Raises:
            OSError: the rest of the file cannot be written.
        """
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.close()

    def begin_game(self) -> None:
        """Set the score in the overlay to 0."""
        self._overlay.begin_game()

    def write_frame(
        self, core: Core, action: int | None = None, reward: int = 0, image: ByteArray | None = None
    ) -> None:
        """Append a frame. It defers errors, because it is called in the middle of steps.

        Args:
            core: the core whose screen, sound and overlay values are recorded.
            action: ALE's number of the frame's action; None means no action, and silence.
            reward: the reward of the frame.
            image: recorded in place of the core's screen.
        """
        self._overlay.add(reward)
        writer = self._writer
        if writer is None:
            return
        self.score += reward
        samples = core.audio() if self._settings.sound and action is not None else None
        caption = self._overlay.caption((action,), core.ram()) if self._overlay.parts else ""
        try:
            writer.write(self._overlay.draw(core.screen_rgb() if image is None else image), samples, caption)
        except Exception as error:
            self._writer = None
            text = f"the recording has ended after {writer.frames} frames: {getattr(error, 'strerror', error)}"
            self._deferred_error = OSError(getattr(error, "errno", None) or errno.EIO, text, str(writer.path))
            self._deferred_error.__cause__ = error
