"""`EpisodeRecorder`: videos and statistics of episodes, in the files that Gym's Monitor wrote.

A folder has, for each recorder that wrote to it, a manifest, statistics of all episodes (`*.stats.json`) and some
videos, each with a `*.meta.json`. Their names share the numbers of the recorder and of the process, which scripts
expect.
"""

import json
import os
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any, Literal, Protocol

import gymnasium

import atari
from atari.classic.video_recorder import Renderable, VideoRecorder
from atari.files import durable

_PREFIX = "openaigym"
_numbers = count()

VideoCallable = Callable[[int], bool]


class Monitored(Renderable, Protocol):
    """The part of an environment that a recorder needs."""

    spec: Any


class EpisodeRecorder:
    """Writes videos of some episodes and the statistics of all episodes; it takes the arguments of `Monitor`.

    The owner calls `check_running` before a step, `add_step` after it, `begin_episode` after a reset, and `close`.
    """

    def __init__(
        self,
        env: Monitored,
        directory: str | os.PathLike[str],
        video_callable: VideoCallable | Literal[False] | None = None,
        force: bool = False,
        resume: bool = False,
        write_upon_reset: bool = False,
        uid: str | None = None,
        mode: Literal["training", "evaluation"] | None = None,
    ) -> None:
        if mode not in (None, "training", "evaluation"):
            raise gymnasium.error.Error(f"mode must be 'training' or 'evaluation', got {mode!r}")
        self.directory = Path(directory).absolute()
        _prepare(self.directory, force, resume)
        self.file_infix = f"{next(_numbers)}.{uid or os.getpid()}"
        self.videos: list[tuple[str, str]] = []
        self.statistics = EpisodeStatistics(mode or "training")
        self._env = env
        self._write_upon_reset = write_upon_reset
        can_record = video_callable is not False and "rgb_array" in env.metadata.get("render.modes", [])
        self._is_recorded: VideoCallable = (video_callable or cubes_then_thousands) if can_record else _never
        self._video: VideoRecorder | None = None
        self._closed = False

    @property
    def stats_path(self) -> Path:
        """The file of the statistics."""
        return self.directory / f"{_PREFIX}.episode_batch.{self.file_infix}.stats.json"

    def begin_episode(self) -> None:
        """End the last episode, after a reset, and begin the next."""
        self._finish_episode()
        self.statistics.begin()
        number = len(self.statistics.rewards)
        if not self._closed and self._is_recorded(number):
            self._begin_video(number)

    def check_running(self) -> None:
        """Raise an error for a step after the end of an episode.

        Raises:
            gymnasium.error.Error: the episode is over.
        """
        if self.statistics.done and not self._closed:
            raise gymnasium.error.Error("the episode is over, and Monitor does not go on; call env.reset() first")

    def add_step(self, reward: Any, done: bool) -> None:
        """Add a step to the statistics and its frame to the video."""
        self.statistics.add(reward, done)
        if self._video is not None:
            self._video.capture_frame()
        if done:
            self._finish_episode()

    def close(self) -> None:
        """Write the files; later calls do nothing."""
        if not self._closed:
            self._finish_episode()
            self._write()
            self._closed = True

    def _begin_video(self, number: int) -> None:
        name = f"{_PREFIX}.video.{self.file_infix}.video{number:06}"
        self._video = VideoRecorder(self._env, self.directory / f"{name}.mp4", metadata={"episode_id": number})
        self._video.capture_frame()
        self.videos.append((f"{name}.mp4", f"{name}.meta.json"))

    def _finish_episode(self) -> None:
        video, self._video = self._video, None
        if video is not None:
            video.close()
        if self.statistics.finish() and self._write_upon_reset:
            self._write()

    def _write(self) -> None:
        _write_json(self.stats_path, self.statistics.as_json())
        spec = self._env.spec
        manifest = {
            "stats": self.stats_path.name,
            "videos": self.videos,
            "env_info": {"gym_version": f"atari-envs {atari.__version__}", "env_id": spec and spec.id},
        }
        _write_json(self.directory / f"{_PREFIX}.manifest.{self.file_infix}.manifest.json", manifest)


class EpisodeStatistics:
    """Length, return and time of each episode."""

    def __init__(self, kind: str) -> None:
        self.rewards: list[float] = []
        self.lengths: list[int] = []
        self.total_steps = 0
        self.done = False
        self._kind = kind
        self._first_reset: float | None = None
        self._timestamps: list[float] = []
        self._steps, self._reward = 0, 0.0

    def begin(self) -> None:
        """Begin an episode, after a reset."""
        self._first_reset = self._first_reset or time.time()
        self.done = False

    def add(self, reward: Any, done: bool) -> None:
        """Add a step."""
        self._steps += 1
        self.total_steps += 1
        self._reward += float(reward)
        self.done = done

    def finish(self) -> bool:
        """Add the episode to the lists; False if it has no steps."""
        if not self._steps:
            return False
        self.lengths.append(self._steps)
        self.rewards.append(self._reward)
        self._timestamps.append(time.time())
        self._steps, self._reward = 0, 0.0
        return True

    def as_json(self) -> dict[str, Any]:
        """The content of the statistics file."""
        return {
            "initial_reset_timestamp": self._first_reset,
            "timestamps": self._timestamps,
            "episode_lengths": self.lengths,
            "episode_rewards": self.rewards,
            "episode_types": [self._kind[0]] * len(self.lengths),
        }


def cubes_then_thousands(episode: int) -> bool:
    """Whether an episode is recorded by default: 0, 1, 8, 27, ..., then every thousandth."""
    return round(episode ** (1 / 3)) ** 3 == episode if episode < 1000 else episode % 1000 == 0


def _never(_: int) -> bool:
    return False


def _prepare(directory: Path, force: bool, resume: bool) -> None:
    directory.mkdir(parents=True, exist_ok=True)
    written = sorted(directory.glob(f"{_PREFIX}.*"))
    if force:
        for file in written:
            file.unlink()
    elif written and not resume:
        raise gymnasium.error.Error(
            f"{directory} has files of another Monitor, such as {written[0].name}; use another folder, force=True to "
            "remove them, or resume=True to add to them"
        )


def _write_json(path: Path, data: dict[str, Any]) -> None:
    durable.write_file(path, json.dumps(data).encode())
