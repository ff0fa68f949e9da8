"""`Camera`: films a core, frame by frame, and keeps its troubles to itself until someone asks."""

import errno
import os
from fractions import Fraction
from pathlib import Path
from typing import Any

from atari.actions import Action
from atari.cores import ByteArray, Core
from atari.cores.options import check_name
from atari.recording.formats import FORMATS
from atari.recording.movie import import_av
from atari.recording.options import VideoOptions
from atari.recording.trouble import Troubled
from atari.recording.video import VideoWriter

OVERLAYS = ("score", "action", "ram")
_RAM_LINES = 8


class Shot:
    """What a recording looks like, for all videos of a wrapper.

    Args:
        format: name of a format, such as "mp4".
        size: (rows, columns) of the screens.
        fps: frames a second.
        scale: of the pixels.
        sound: whether there is sound, in formats that have it.
        overlay: what is written beneath the picture, of `OVERLAYS`.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range.
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
    ) -> None:
        check_name("format", format, [suffix[1:] for suffix in FORMATS])
        if isinstance(overlay, str) or not set(overlay or ()) <= set(OVERLAYS):
            raise ValueError(f"overlay is a tuple of some of {', '.join(map(repr, OVERLAYS))}, got {overlay!r}")
        self.format, self.size, self.fps, self.scale = format, size, fps, scale
        self.sound = bool(sound) and FORMATS[f".{format}"].sound is not None
        self.overlay = tuple(overlay or ())
        self.caption_lines = bool({"score", "action"} & set(self.overlay)) + _RAM_LINES * ("ram" in self.overlay)
        VideoOptions.check(self.path("", "x"), size, fps, **self._options())
        if FORMATS[f".{format}"].container:
            import_av()

    def _options(self) -> dict[str, Any]:
        return {"scale": self.scale, "sound": self.sound, "caption_lines": self.caption_lines}

    def path(self, folder: str | os.PathLike[str], name: str) -> Path:
        """Where a video of this name is."""
        return Path(folder, name, "%06d.png") if self.format == "png" else Path(folder, f"{name}.{self.format}")

    def writer(self, path: Path) -> VideoWriter:
        """A new file."""
        return VideoWriter(path, self.size, self.fps, **self._options())


class Camera(Troubled):
    """Films the core of an environment, as an observer of its frames."""

    def __init__(self, shot: Shot) -> None:
        self._shot = shot
        self._writer: VideoWriter | None = None
        self._score = 0

    @property
    def filming(self) -> bool:
        """Whether a video is being written."""
        return self._writer is not None

    @property
    def frames(self) -> int:
        """Frames of this video so far."""
        return 0 if self._writer is None else self._writer.frames

    def start(self, path: Path) -> None:
        """Begin a video.

        Raises:
            OSError: the file cannot be written.
        """
        self._writer = self._shot.writer(path)

    def stop(self) -> None:
        """Complete the video.

        Raises:
            OSError: the last of it cannot be written.
        """
        writer, self._writer = self._writer, None
        if writer is not None:
            writer.close()

    def begin_game(self) -> None:
        """A new game: its score is 0."""
        self._score = 0

    def take(self, core: Core, action: int | None = None, reward: int = 0, picture: ByteArray | None = None) -> None:
        """Film what a core shows, or another picture. It raises nothing, as it is called in the middle of steps.

        Args:
            core: whose sound and numbers are recorded.
            action: that was played for it, by ALE's number; None is none, and silence.
            reward: of the action.
            picture: to film in place of the core's screen.
        """
        self._score += reward
        writer = self._writer
        if writer is None:
            return
        samples = core.audio() if self._shot.sound and action is not None else None
        caption = self._caption(core, action) if self._shot.overlay else ""
        try:
            writer.write(core.screen_rgb() if picture is None else picture, samples, caption)
        except Exception as error:
            self._writer = None
            text = f"the recording has ended after {writer.frames} frames: {getattr(error, 'strerror', error)}"
            self._trouble = OSError(getattr(error, "errno", None) or errno.EIO, text, str(writer.path))
            self._trouble.__cause__ = error

    def _caption(self, core: Core, action: int | None) -> str:
        words = []
        if "score" in self._shot.overlay:
            words.append(f"score {self._score}")
        if "action" in self._shot.overlay:
            words.append(f"action {'-' if action is None else Action(action).name}")
        lines = ["   ".join(words)] if words else []
        if "ram" in self._shot.overlay:
            rows = core.ram().reshape(_RAM_LINES, 16)
            lines += [f"{128 + 16 * i:02X}:  {rows[i].tobytes().hex(' ').upper()}" for i in range(_RAM_LINES)]
        return "\n".join(lines)
