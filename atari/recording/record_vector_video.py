"""`RecordVectorVideo`: videos of a vector environment, of one of its environments or of all in a mosaic.

The games of an `AtariVectorEnv` are played in C++, and of a frame skip only the last screen can be seen from outside.
So each environment that is filmed has a core of its own that follows it: brought to the same state, it plays the same
action frame by frame, and arrives where the environment arrives, to the byte. Only what a reset plays (no-ops, FIRE) is
not followed; a video goes on with the screen that the reset ends with.
"""

import math
import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import AutoresetMode, VectorWrapper

from atari.cores.options import check_integer
from atari.recording.camera import Shot
from atari.recording.filming import Filming, make_folder
from atari.recording.follower import Follower
from atari.recording.schedule import Schedule, Trigger
from atari.recording.video import frame_rate
from atari.rendering import tile
from atari.vector import AtariVectorEnv


class RecordVectorVideo(Filming, VectorWrapper[Any, Any, Any, Any, Any], RecordConstructorArgs):
    """Record videos of a vector environment.

    Arguments, names of files and what is recorded when are those of `gymnasium.wrappers.vector.RecordVideo`; the videos
    are those of `atari.recording.RecordVideo`, with every emulated frame. All else is said there. Environments that end
    an episode inside a skip stand still in a mosaic until the others have played theirs.

    Args:
        env: an `AtariVectorEnv` with batches of all environments, in any wrappers that leave actions as they are.
        video_folder: where the videos go; it is made.
        record_first_only: film only environment `index`, instead of a mosaic of all.
        video_aspect_ratio: width and height that the mosaic should have to each other, roughly.
        episode_trigger, step_trigger, video_length, name_prefix, fps, disable_logger, gc_trigger: see `RecordVideo`.
            Episodes are those of environment `index`; a step is one of all environments.
        index: the environment whose episodes are counted and whose sound and overlay are recorded.
        format, scale, sound, overlay: see `RecordVideo`.

    Raises:
        TypeError: the environment is no `AtariVectorEnv`, or an argument is of the wrong kind.
        ValueError: an argument is out of range, or batches are smaller than the number of environments.
        OSError: the folder cannot be made or written to.
        RuntimeError: of `step`: a wrapper beneath has changed the actions.
    """

    def __init__(
        self,
        env: Any,
        video_folder: str | os.PathLike[str],
        record_first_only: bool = False,
        video_aspect_ratio: tuple[int, int] = (1, 1),
        episode_trigger: Trigger | None = None,
        step_trigger: Trigger | None = None,
        video_length: int = 0,
        name_prefix: str = "rl-video",
        fps: float | None = None,
        disable_logger: bool = True,
        gc_trigger: Callable[[int], bool] | None = None,
        *,
        index: int = 0,
        format: str = "mp4",
        scale: int = 2,
        sound: bool = True,
        overlay: tuple[str, ...] | None = None,
    ) -> None:
        RecordConstructorArgs.__init__(
            self,
            video_folder=video_folder,
            record_first_only=record_first_only,
            video_aspect_ratio=video_aspect_ratio,
            episode_trigger=episode_trigger,
            step_trigger=step_trigger,
            video_length=video_length,
            name_prefix=name_prefix,
            fps=fps,
            disable_logger=disable_logger,
            gc_trigger=gc_trigger,
            index=index,
            format=format,
            scale=scale,
            sound=sound,
            overlay=overlay,
        )
        inner = getattr(env, "unwrapped", env)
        if not isinstance(inner, AtariVectorEnv):
            raise TypeError(f"RecordVectorVideo films an atari.AtariVectorEnv, got {type(inner).__name__}")
        if inner.batch_size != inner.num_envs:
            raise ValueError(f"RecordVectorVideo needs batches of all environments, got batch_size={inner.batch_size}")
        super().__init__(env)
        self._vector = inner
        self._index = check_integer("index", index, 0, inner.num_envs - 1)
        filmed = [self._index] if record_first_only else list(range(inner.num_envs))
        self._columns = _columns([inner.games[i].screen.shape for i in filmed], video_aspect_ratio)
        rate = frame_rate(inner.games[self._index]) if fps is None else fps
        size = tile([np.zeros((*inner.games[i].screen.shape, 3), np.uint8) for i in filmed], self._columns).shape
        self._shot = Shot(format, (size[0], size[1]), rate, scale, sound, overlay)
        self._schedule = Schedule(episode_trigger, step_trigger, video_length, name_prefix)
        self.video_folder = make_folder(video_folder)
        self._set_up_camera()
        self._followers = [Follower(inner, i) for i in filmed]
        self._sounding = next(follower for follower in self._followers if follower.index == self._index)
        self._done = np.zeros(inner.num_envs, np.bool_)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environments; if environment `index` is among them, its episode ends."""
        self._camera.raise_trouble()
        mask = (options or {}).get("reset_mask")
        chosen = np.ones(self.num_envs, np.bool_) if mask is None else mask
        ends = bool(chosen[self._index])
        if ends:
            self._before_episode()
        result = self.env.reset(seed=seed, options=options)
        self._done = self._done & ~chosen
        if ends:
            self._schedule.episode_id += 1
            self._film_resets()
        self._count()
        return result

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Play a step of all environments, and film their frames."""
        self._camera.raise_trouble()
        mode = self._vector.metadata["autoreset_mode"]
        resets = self._done if mode == AutoresetMode.NEXT_STEP else np.zeros(self.num_envs, np.bool_)
        begins = bool(resets[self._index])
        if begins:
            self._before_episode()
        self._before_step()
        if self.recording:
            self._catch_up(self._followers)
        result = self.env.step(actions)
        _, _, terminations, truncations, info = result
        self._done = terminations | truncations
        self._film_step(actions, resets, info)
        if mode == AutoresetMode.SAME_STEP and self._done[self._index]:
            begins = True
            self._before_episode()
            self._film_resets()
        self._schedule.step_id += 1
        self._schedule.episode_id += begins
        self._count()
        return result

    def _film_step(self, actions: Any, resets: npt.NDArray[np.bool_], info: dict[str, Any]) -> None:
        """Have the followers play what the environments have played, and film it."""
        if not self.recording:
            return
        moves = [follower.move(actions, bool(resets[follower.index]), info) for follower in self._followers]
        self._catch_up(follower for follower, move in zip(self._followers, moves, strict=True) if not move.frames)
        for frame in range(max(int(resets.any()), *(move.frames for move in moves))):
            for follower, move in zip(self._followers, moves, strict=True):
                follower.play(move, frame)
            self._take(self._sounding.played)
        for follower in self._followers:
            follower.check()
        self._catch_up(self._followers)

    def _film_resets(self) -> None:
        """Film where the environments are after a reset, in one picture."""
        if self.recording:
            self._catch_up(self._followers)
            self._take(None)

    def _take(self, played: tuple[int, int] | None) -> None:
        action, reward = (None, 0) if played is None else played
        picture = tile([follower.screen for follower in self._followers], self._columns)
        self._camera.take(self._sounding.core, action, reward, picture)

    def _catch_up(self, followers: Iterable[Follower]) -> None:
        for follower in followers:
            if follower.catch_up() and follower is self._sounding:
                self._camera.begin_game()


def _columns(shapes: Sequence[tuple[int, int]], aspect_ratio: Any) -> int:
    """In how many columns to put screens of these shapes so that the picture is nearest to a ratio of sides."""
    try:
        wanted = float(aspect_ratio[0]) / float(aspect_ratio[1])
    except (TypeError, IndexError, ValueError, ZeroDivisionError):
        wanted = 0.0
    if not 0.0 < wanted < math.inf:
        raise ValueError(f"video_aspect_ratio is (width, height), two numbers above 0, got {aspect_ratio!r}")
    count, height, width = len(shapes), max(shape[0] for shape in shapes), 2 * shapes[0][1]

    def distance(columns: int) -> float:
        return abs(math.log(columns * width / (math.ceil(count / columns) * height) / wanted))

    return min(range(1, count + 1), key=distance)
