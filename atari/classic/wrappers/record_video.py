"""`RecordVideo`: videos of some episodes, or from some steps."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from atari.classic.core import Env, Step, Wrapper
from atari.classic.monitor_files import capped_cubic_video_schedule
from atari.classic.video_recorder import VideoRecorder

Trigger = Callable[[int], bool]


class RecordVideo(Wrapper):
    """Writes a video of each episode, or from each step, that a trigger chooses.

    Args:
        env: an environment that renders "rgb_array".
        video_folder: the folder of the videos; it is made if necessary.
        episode_trigger: a function of the number of an episode that returns whether to record it. Without a trigger,
            episodes 0, 1, 8, 27, ..., 1000, 2000, ... are recorded.
        step_trigger: a function of the number of steps so far, instead.
        video_length: the steps of a video; 0 means until the end of the episode.
        name_prefix: the beginning of the files' names, before "-episode-0.mp4" or "-step-0.mp4".

    Raises:
        ValueError: both triggers are given.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`), from the first recorded frame.
    """

    def __init__(
        self,
        env: Env,
        video_folder: str | os.PathLike[str],
        episode_trigger: Trigger | None = None,
        step_trigger: Trigger | None = None,
        video_length: int = 0,
        name_prefix: str = "rl-video",
    ) -> None:
        if episode_trigger is not None and step_trigger is not None:
            raise ValueError("RecordVideo takes episode_trigger or step_trigger, got both; leave one out")
        super().__init__(env)
        self.video_folder = Path(video_folder).absolute()
        self.video_folder.mkdir(parents=True, exist_ok=True)
        self.episode_trigger = episode_trigger or (None if step_trigger else capped_cubic_video_schedule)
        self.step_trigger = step_trigger
        self.video_length = video_length
        self.name_prefix = name_prefix
        self.step_id, self.episode_id, self.recorded_frames = 0, 0, 0
        self.video_recorder: VideoRecorder | None = None

    @property
    def recording(self) -> bool:
        """Whether a video is being recorded."""
        return self.video_recorder is not None

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        self._begin_if_chosen()
        return observation

    def _step(self, action: Any) -> Step:
        result = self.env.step(action)
        done = result[2]
        self.step_id += 1
        self.episode_id += bool(done)
        if self.video_recorder is None:
            self._begin_if_chosen()
            return result
        self.video_recorder.capture_frame()
        self.recorded_frames += 1
        if self.recorded_frames > self.video_length if self.video_length else done:
            self._end()
        return result

    def _close(self) -> None:
        self._end()
        self.env.close()

    def _begin_if_chosen(self) -> None:
        if self.step_trigger is not None:
            chosen, name = self.step_trigger(self.step_id), f"step-{self.step_id}"
        else:
            assert self.episode_trigger is not None
            chosen, name = self.episode_trigger(self.episode_id), f"episode-{self.episode_id}"
        if chosen and self.video_recorder is None:
            facts = {"step_id": self.step_id, "episode_id": self.episode_id}
            path = self.video_folder / f"{self.name_prefix}-{name}"
            self.video_recorder = VideoRecorder(self.env, base_path=path, metadata=facts)
            self.video_recorder.capture_frame()
            self.recorded_frames = 1

    def _end(self) -> None:
        recorder, self.video_recorder = self.video_recorder, None
        if recorder is not None:
            recorder.close()
