"""`RecordVideo`: videos of some episodes, or from some steps."""

import os
from collections.abc import Callable
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
        self.video_folder = os.path.abspath(video_folder)
        os.makedirs(self.video_folder, exist_ok=True)
        self.episode_trigger = episode_trigger or (None if step_trigger else capped_cubic_video_schedule)
        self.step_trigger = step_trigger
        self.video_length = video_length
        self.name_prefix = name_prefix
        self.step_id, self.episode_id, self.recorded_frames = 0, 0, 0
        self.is_vector_env: bool = getattr(env, "is_vector_env", False)
        self.recording = self.terminated = self.truncated = False
        self.video_recorder: VideoRecorder | None = None

    def start_video_recorder(self) -> None:
        """Begin a video."""
        self.close_video_recorder()
        name = f"episode-{self.episode_id}" if self.step_trigger is None else f"step-{self.step_id}"
        self.video_recorder = VideoRecorder(
            env=self.env,
            base_path=os.path.join(self.video_folder, f"{self.name_prefix}-{name}"),
            metadata={"step_id": self.step_id, "episode_id": self.episode_id},
        )
        self.video_recorder.capture_frame()
        self.recorded_frames = 1
        self.recording = True

    def close_video_recorder(self) -> None:
        """End the video."""
        if self.recording and self.video_recorder is not None:
            self.video_recorder.close()
        self.recording = False

    def _video_enabled(self) -> bool:
        """Whether a video begins now."""
        if self.step_trigger is not None:
            return self.step_trigger(self.step_id)
        assert self.episode_trigger is not None
        return self.episode_trigger(self.episode_id)

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        if not self.recording and self._video_enabled():
            self.start_video_recorder()
        return observation

    def _step(self, action: Any) -> Step:
        result: Any = self.env.step(action)
        done = bool(result[2][0] if self.is_vector_env else result[2])  # of a vector, the first environment counts
        self.step_id += 1
        limit = False if self.is_vector_env else bool(result[3].get("TimeLimit.truncated", False))
        self.terminated, self.truncated = done and not limit, done and limit
        self.episode_id += done
        if self.recording:
            assert self.video_recorder is not None
            self.video_recorder.capture_frame()
            self.recorded_frames += 1
            if self.recorded_frames > self.video_length if self.video_length else done:
                self.close_video_recorder()
        elif self._video_enabled():
            self.start_video_recorder()
        return result

    def _close(self) -> None:
        self.close_video_recorder()
        self.env.close()
