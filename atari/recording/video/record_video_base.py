"""`RecordVideoBase`: the common base of `RecordVideo` and `RecordVectorVideo`.

It begins and ends videos and counts episodes and steps. The subclasses record the frames of a step.
"""

import gc
import os
import shutil
import weakref
from collections.abc import Callable, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

from gymnasium import logger

from atari.recording.video.recorder import VideoRecorder, VideoSettings
from atari.recording.video.schedule import Schedule
from atari.task import Task


class RecordedFrames(Sequence[Any]):
    """The number of frames of an open video; the frames themselves are in its file."""

    def __init__(self, count: int) -> None:
        self._count = count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, index: Any) -> Any:
        raise LookupError(f"frame {index!r} is not kept in memory; read the video's file once it is complete")


def _scheduled(name: str, text: str) -> Any:
    """An attribute of the `Schedule`, which can be set."""
    return property(attrgetter(f"_schedule.{name}"), lambda self, value: self._schedule.set(name, value), doc=text)


class RecordVideoBase:
    """The first base class of a recording wrapper.

    The wrapper calls `_before_episode`, `_before_step` and `_count`, and writes its frames to `_recorder`, which its
    method `_watch` makes.
    """

    video_folder: str
    video_path: str = ""
    """The path of the open or last video; "" before the first."""
    _settings: VideoSettings
    _schedule: Schedule
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
    episode_trigger = _scheduled("episode_trigger", "Whether to record an episode, by its number; or None.")
    step_trigger = _scheduled("step_trigger", "Whether to begin a video at a step, by its number; or None.")
    video_length = _scheduled("video_length", "The steps in a video; infinite if it ends with its episode.")
    name_prefix = _scheduled("name_prefix", "The start of the names of the videos.")

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

    @property
    def episode_id(self) -> int:
        """The number of this episode (in a vector, of environment `index`), from 0; -1 before the first."""
        return self._schedule.episode_id

    @property
    def step_id(self) -> int:
        """The number of the last step over all episodes, from 0; -1 before the first."""
        return self._schedule.step_id

    def start_recording(self, video_name: str) -> None:
        """Complete the current video and begin one of this name, which has no suffix.

        Raises:
            OSError: a file cannot be written.
        """
        self.stop_recording()
        path = self._settings.path(self.video_folder, video_name)
        self._recorder.start(path)
        self.video_path = str(path)
        self._schedule.start_video()

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
        if self.recording and self._schedule.by_episode:
            self.stop_recording()
        if (name := self._schedule.episode_video()) is not None:
            self.start_recording(name)

    def _before_step(self) -> None:
        if (name := self._schedule.step_video()) is not None:
            self.start_recording(name)

    def _count(self) -> None:
        if self.recording and self._schedule.count_step():
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
