"""`Filming`: what `RecordVideo` and `RecordVectorVideo` have in common.

They begin and end videos, count episodes and steps; what a step looks like is theirs alone.
"""

import os
import weakref
from typing import Any

from gymnasium import logger

from atari.recording.camera import Camera, Shot
from atari.recording.schedule import Schedule


class Filming:
    """The first base of a wrapper that films: it calls `_before_...` and `_count`, and has `_camera` take frames."""

    video_folder: str
    _shot: Shot
    _schedule: Schedule

    def _set_up_camera(self) -> None:
        self._camera = Camera(self._shot)
        self._finalizer = weakref.finalize(self, self._camera.stop)  # should nobody call close

    @property
    def recording(self) -> bool:
        """Whether a video is being written."""
        return self._camera.filming

    @property
    def episode_id(self) -> int:
        """The number of this episode, of a vector that of environment `index`; -1 before the first, which is 0."""
        return self._schedule.episode_id

    @property
    def step_id(self) -> int:
        """The number of the last step, over all episodes; -1 before the first, which is 0."""
        return self._schedule.step_id

    def start_recording(self, video_name: str) -> None:
        """Begin a video of this name, without an ending; the one being recorded is completed.

        Raises:
            OSError: a file cannot be written.
        """
        self.stop_recording()
        self._camera.start(self._shot.path(self.video_folder, video_name))
        self._schedule.begin()

    def stop_recording(self) -> None:
        """Complete the video; without one, nothing happens.

        Raises:
            OSError: the last of it cannot be written.
        """
        self._camera.stop()

    def _before_episode(self) -> None:
        if self.recording and self._schedule.by_episode:
            self.stop_recording()
        if (name := self._schedule.episode_video()) is not None:
            self.start_recording(name)

    def _before_step(self) -> None:
        if (name := self._schedule.step_video()) is not None:
            self.start_recording(name)

    def _count(self) -> None:
        if self.recording and self._schedule.take():
            self.stop_recording()

    def close(self, **kwargs: Any) -> None:
        """Complete the video and close what is filmed."""
        try:
            self._camera.raise_trouble()
            self.stop_recording()
        finally:
            super().close(**kwargs)  # type: ignore[misc]  # the wrapper's


def make_folder(video_folder: str | os.PathLike[str]) -> str:
    """Make the folder of the videos, warn if it is there already, and return its absolute path.

    Raises:
        OSError: it cannot be made or written to.
    """
    folder = os.path.abspath(video_folder)
    if os.path.isdir(folder):
        logger.warn(f"videos of the same names in {folder} will be replaced; choose another video_folder to keep them")
    os.makedirs(folder, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"videos cannot be written into {folder}; choose another video_folder")
    return folder
