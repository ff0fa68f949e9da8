"""`RecordVideoBase`: the common base of `RecordVideo` and `RecordVectorVideo`, with their recorder of a core's frames.

It counts episodes and steps, and begins and ends videos as Gymnasium's `RecordVideo` would, under the same file names.
Gymnasium decides after a reset or a step and records the frame after it. This class decides before the reset or step,
so that the video includes the frames inside it. The subclasses record these frames.
"""

import errno
import gc
import json
import os
import shutil
import weakref
from collections.abc import Callable, Sequence
from fractions import Fraction
from math import inf
from operator import attrgetter
from pathlib import Path
from typing import Any

from gymnasium import logger

from atari.base.validation import check_integer, check_name
from atari.cores import ByteArray, Core
from atari.games.game import Game
from atari.recording.recordable import DeferredErrorMixin
from atari.recording.video.encoder import import_av
from atari.recording.video.facts import facts_of
from atari.recording.video.formats import FORMATS
from atari.recording.video.options import VideoOptions
from atari.recording.video.overlay import Overlay
from atari.recording.video.writer import VideoWriter
from atari.task import Task

Trigger = Callable[[int], bool]


class VideoSettings:
    """The settings of all videos of a wrapper, see `RecordVideo`; `size` is (rows, columns) of the frames of `game`.

    Raises:
        TypeError, ValueError: an argument has the wrong type or is out of range.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
    """

    def __init__(
        self,
        format: str,
        game: Game,
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
        self.game, self.overlay = game, Overlay(overlay, game)
        self.format, self.size, self.scale = format, self.overlay.size(size), scale
        self.sound = bool(sound) and FORMATS[f".{format}"].sound is not None
        self.set_fps(fps)
        if FORMATS[f".{format}"].container:
            import_av()

    def set_fps(self, fps: Fraction | float) -> None:
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
        self._overlay = Overlay(settings.overlay.parts, settings.game)
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
        caption = self._overlay.caption((action,), core.ram(), lives=(core.lives,)) if self._overlay.parts else ""
        try:
            writer.write(self._overlay.draw(core.screen_rgb() if image is None else image), samples, caption)
        except Exception as error:
            self._writer = None
            text = f"the recording has ended after {writer.frames} frames: {getattr(error, 'strerror', error)}"
            self._deferred_error = OSError(getattr(error, "errno", None) or errno.EIO, text, str(writer.path))
            self._deferred_error.__cause__ = error


class RecordedFrames(Sequence[Any]):
    """The number of frames of an open video; the frames themselves are in its file."""

    def __init__(self, count: int) -> None:
        self._count = count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, index: Any) -> Any:
        raise LookupError(f"frame {index!r} is not kept in memory; read the video's file once it is complete")


def capped_cubic_video_schedule(episode_id: int) -> bool:
    """Return whether Gymnasium's default records an episode: 0, 1, 8, 27, ... 729, 1000, then every 1000th."""
    if episode_id < 1000:
        return bool(round(episode_id ** (1.0 / 3)) ** 3 == episode_id)
    return episode_id % 1000 == 0


def _setting(name: str, text: str) -> Any:
    """An argument that can be set, for the videos that begin from then on; `video_length` for the open one too."""
    own = f"_{name}"
    return property(attrgetter(own), lambda self, value: setattr(self, own, _checked(name, value)), doc=text)


def _checked(name: str, value: Any) -> Any:
    if name.endswith("_trigger") and value is not None and not callable(value):
        raise TypeError(f"{name} is a function of a number, got {value!r}")
    if name == "name_prefix" and not isinstance(value, str):
        raise TypeError(f"name_prefix is a text, got {value!r}")
    if name == "video_length" and value != inf:
        value = check_integer(name, value, 0, 2**31) or inf
    return value


class RecordVideoBase:
    """The first base class of a recording wrapper.

    The wrapper calls `_before_episode`, `_before_step` and `_count`, and writes its frames to `_recorder`, which its
    method `_watch` makes.
    """

    video_folder: str
    video_path: str = ""
    """The path of the open or last video; "" before the first."""
    _settings: VideoSettings
    _best: tuple[Path, int] | None = None
    _watch: Any

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the open video: a copy keeps the counters and records from its next trigger on."""
        return {name: value for name, value in vars(self).items() if name not in ("_recorder", "_finalizer")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._watch()

    def _make_recorder(self, task: Callable[[], Task]) -> None:
        self._recorder = VideoRecorder(self._settings, task)
        self._finalizer = weakref.finalize(self, self._recorder.stop)  # without a call of close

    # Gymnasium's attributes. What is set applies to the videos that begin from then on.

    disable_logger: bool = True
    gc_trigger: Callable[[int], bool] | None = None
    episode_trigger = _setting("episode_trigger", "Whether to record an episode, by its number; or None.")
    step_trigger = _setting("step_trigger", "Whether to begin a video at a step, by its number; or None.")
    video_length = _setting("video_length", "The steps in a video; infinite if it ends with its episode.")
    name_prefix = _setting("name_prefix", "The start of the names of the videos.")
    episode_id: int = -1
    """The number of this episode (in a vector, of environment `index`), from 0; -1 before the first."""
    step_id: int = -1
    """The number of the last step over all episodes, from 0; -1 before the first."""

    def _plan(self, episodes: Trigger | None, steps: Trigger | None, video_length: int, name_prefix: str) -> None:
        """Set the triggers, the length of the videos and their names; see `RecordVideo`.

        A reset counts as a step of `video_length`.
        """
        self.episode_trigger = capped_cubic_video_schedule if episodes is None and steps is None else episodes
        self.step_trigger, self.video_length, self.name_prefix = steps, video_length, name_prefix
        self._asked: dict[str, int] = {}  # by unit: the last number that was passed to its trigger
        self._counted = 0  # the steps and resets in a video

    @property
    def video_name(self) -> str:
        """The name of the file of the open or last video; "" before the first."""
        return os.path.basename(self.video_path)

    @property
    def frames_per_sec(self) -> float:
        """The frames a second of the videos."""
        fps = self._settings.fps
        return fps if isinstance(fps, (int, float)) else float(fps)

    @frames_per_sec.setter
    def frames_per_sec(self, fps: float) -> None:
        self._settings.set_fps(fps)

    @property
    def recorded_frames(self) -> RecordedFrames:
        """A sequence with the length of the open video; its frames are in the file, not in memory."""
        return RecordedFrames(self._recorder.frames)

    @property
    def recording(self) -> bool:
        """Whether a video is being written."""
        return self._recorder.recording

    def start_recording(self, video_name: str) -> None:
        """Complete the current video and begin one of this name, which has no suffix.

        Raises:
            OSError: a file cannot be written.
        """
        self.stop_recording()
        path = self._settings.path(self.video_folder, video_name)
        self._recorder.start(path)
        self.video_path = str(path)
        self._counted = 0

    def stop_recording(self) -> None:
        """Complete the video; without one, do nothing. With keep="best", delete it or the best so far.

        Raises:
            OSError: the rest of the file cannot be written.
        """
        path, score = self._recorder.path, self._recorder.score
        self._recorder.stop()
        if path is None:
            return
        if not self.disable_logger:
            print(f"atari.recording: the video {path} is complete")
        if self._settings.keep == "best":
            self._keep_best(path, score)
        if self.gc_trigger is not None and self.gc_trigger(self.episode_id):
            gc.collect()

    def _keep_best(self, path: Path, score: int) -> None:
        """Delete a video that is not better than the best so far, or else that one."""
        if self._best is not None and self._best[0] != path:
            worse = path if score <= self._best[1] else self._best[0]
            shutil.rmtree(worse.parent) if self._settings.format == "png" else worse.unlink(missing_ok=True)
            if worse == path:
                return
        self._best = path, score

    def _before_episode(self) -> None:
        if self.recording and self.video_length == inf:
            self.stop_recording()
        self._begin_video("episode", self.episode_trigger, self.episode_id + 1)

    def _before_step(self) -> None:
        self._begin_video("step", self.step_trigger, self.step_id + 1)

    def _begin_video(self, unit: str, trigger: Trigger | None, number: int) -> None:
        """Begin a video if a trigger selects the number of its unit. Each trigger is called once for a number."""
        if trigger is not None and number != self._asked.get(unit):
            self._asked[unit] = number
            if trigger(number):
                self.start_recording(f"{self.name_prefix}-{unit}-{number}")

    def _count(self) -> None:
        if self.recording:
            self._counted += 1
            if self._counted > self.video_length:
                self.stop_recording()

    def close(self, **kwargs: Any) -> None:
        """Complete the video and close the environment."""
        try:
            self._recorder.raise_deferred_error()
            self.stop_recording()
        finally:
            super().close(**kwargs)  # type: ignore[misc]  # the wrapper's


def make_folder(video_folder: str | os.PathLike[str], name_prefix: str) -> str:
    """Create the folder of the videos, warn if it has videos of this prefix, and return its absolute path.

    Raises:
        OSError: the folder cannot be created or written to.
    """
    folder = os.path.abspath(video_folder)
    if os.path.isdir(folder) and any(name.startswith(f"{name_prefix}-") for name in os.listdir(folder)):
        logger.warn(f"videos of the same names in {folder} will be replaced; choose another video_folder to keep them")
    os.makedirs(folder, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"videos cannot be written into {folder}; choose another video_folder")
    return folder
