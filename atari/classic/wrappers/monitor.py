"""`Monitor`: videos and statistics of the episodes of an environment, in the files of old.

A folder holds, for each monitor that wrote to it, a manifest, statistics of all episodes (`*.stats.json`) and some
videos, each with a `*.meta.json`. Their names share the number of the monitor and of the process: scripts that read
such folders find what they look for.
"""

import atexit
import json
import os
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any, Literal

import gymnasium

import atari
from atari.classic.core import Env, Step, Wrapper
from atari.recording import VideoWriter

_PREFIX = "openaigym"
_SMALL = 300  # rows; smaller pictures are doubled, to keep their colours sharp
_numbers = count()
_open: "set[Monitor]" = set()

VideoCallable = Callable[[int], bool]


class Monitor(Wrapper):
    """Writes videos of episodes 0, 1, 8, 27, ..., 1000, 2000, ..., and the statistics of all.

    An episode ends when it is done, or with the next `reset`.

    Args:
        env: an environment.
        directory: where to write; it is made if necessary.
        video_callable: called with the number of an episode, says whether to film it; None films those above, False
            none. Environments that cannot render "rgb_array" are not filmed.
        force: remove what other monitors wrote there.
        resume: keep it, and add to it.
        write_upon_reset: write the statistics after every episode, not only when closed.
        uid: a name in place of the process's number.
        mode: "training" or "evaluation", as noted with each episode.

    Raises:
        gymnasium.error.Error: another monitor wrote there, and neither `force` nor `resume` is given; from `step`: the
            episode is over.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed (extra `video`); `video_callable=False` does
            without.
    """

    def __init__(
        self,
        env: Env,
        directory: str | os.PathLike[str],
        video_callable: VideoCallable | Literal[False] | None = None,
        force: bool = False,
        resume: bool = False,
        write_upon_reset: bool = False,
        uid: str | None = None,
        mode: Literal["training", "evaluation"] | None = None,
    ) -> None:
        super().__init__(env)
        if mode not in (None, "training", "evaluation"):
            raise gymnasium.error.Error(f"mode must be 'training' or 'evaluation', got {mode!r}")
        self.directory = Path(directory).absolute()
        _prepare(self.directory, force, resume)
        self.file_infix = f"{next(_numbers)}.{uid or os.getpid()}"
        self.videos: list[tuple[str, str]] = []
        self._stats = _Stats(mode or "training")
        self._write_upon_reset = write_upon_reset
        films = video_callable is not False and "rgb_array" in self.metadata.get("render.modes", [])
        self._is_filmed: VideoCallable = (video_callable or cubes_then_thousands) if films else _never
        self._video: VideoWriter | None = None
        self._closed = False
        _open.add(self)

    @property
    def stats_path(self) -> Path:
        """The file of the statistics."""
        return self.directory / f"{_PREFIX}.episode_batch.{self.file_infix}.stats.json"

    def get_total_steps(self) -> int:
        """Steps so far."""
        return self._stats.total_steps

    def get_episode_rewards(self) -> list[float]:
        """The return of each episode that ended."""
        return self._stats.rewards

    def get_episode_lengths(self) -> list[int]:
        """The number of steps of each episode that ended."""
        return self._stats.lengths

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        self._finish_episode()
        self._stats.begin()
        number = len(self._stats.rewards)
        if not self._closed and self._is_filmed(number):
            self._begin_video(number)
        return observation

    def _step(self, action: Any) -> Step:
        if self._stats.done and not self._closed:
            raise gymnasium.error.Error("the episode is over, and Monitor does not go on; call env.reset() first")
        observation, reward, done, info = self.env.step(action)
        self._stats.add(reward, done)
        if self._video is not None:
            self._video.write(self.env.render(mode="rgb_array"))
        if done:
            self._finish_episode()
        return observation, reward, done, info

    def _close(self) -> None:
        if not self._closed:
            self._finish_episode()
            self._write()
            self._closed = True
            _open.discard(self)
        self.env.close()

    def _begin_video(self, number: int) -> None:
        picture = self.env.render(mode="rgb_array")
        rows, columns = picture.shape[:2]
        path = self.directory / f"{_PREFIX}.video.{self.file_infix}.video{number:06}.mp4"
        rate = self.metadata.get("video.frames_per_second", 30)
        self._video = VideoWriter(
            path,
            (rows, columns),
            rate,
            scale=2 if rows < _SMALL or rows % 2 or columns % 2 else 1,
            pixel_aspect=self.metadata.get("video.pixel_aspect", (1, 1)),
        )
        self._video.write(picture)
        meta = path.with_suffix(".meta.json")
        _write_json(meta, {"episode_id": number, "content_type": "video/mp4", "frames_per_second": float(rate)})
        self.videos.append((path.name, meta.name))

    def _finish_episode(self) -> None:
        video, self._video = self._video, None
        if video is not None:
            video.close()
        if self._stats.finish() and self._write_upon_reset:
            self._write()

    def _write(self) -> None:
        _write_json(self.stats_path, self._stats.as_json())
        manifest = {
            "stats": self.stats_path.name,
            "videos": self.videos,
            "env_info": {"gym_version": f"atari-envs {atari.__version__}", "env_id": self.spec and self.spec.id},
        }
        _write_json(self.directory / f"{_PREFIX}.manifest.{self.file_infix}.manifest.json", manifest)


@atexit.register
def _close_all() -> None:
    """Scripts seldom close their monitors, and want their files nevertheless."""
    for monitor in list(_open):
        monitor.close()


class _Stats:
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
        self._first_reset = self._first_reset or time.time()
        self.done = False

    def add(self, reward: Any, done: bool) -> None:
        self._steps += 1
        self.total_steps += 1
        self._reward += float(reward)
        self.done = done

    def finish(self) -> bool:
        """Note the episode, if there was one."""
        if not self._steps:
            return False
        self.lengths.append(self._steps)
        self.rewards.append(self._reward)
        self._timestamps.append(time.time())
        self._steps, self._reward = 0, 0.0
        return True

    def as_json(self) -> dict[str, Any]:
        return {
            "initial_reset_timestamp": self._first_reset,
            "timestamps": self._timestamps,
            "episode_lengths": self.lengths,
            "episode_rewards": self.rewards,
            "episode_types": [self._kind[0]] * len(self.lengths),
        }


def cubes_then_thousands(episode: int) -> bool:
    """Whether an episode is filmed by default: 0, 1, 8, 27, ..., then every thousandth."""
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
    part = path.with_suffix(".part")
    part.write_text(json.dumps(data))
    part.replace(path)  # in one moment: who reads it meanwhile finds the old or the new
