"""`RecordVideo`: Gymnasium's wrapper of this name, with every frame, at the console's speed, with its sound."""

import os
from collections.abc import Callable
from typing import Any

import gymnasium
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import VectorEnv

from atari.env import AtariEnv
from atari.recording.camera import Camera, Shot
from atari.recording.filming import Filming, make_folder
from atari.recording.schedule import Schedule, Trigger
from atari.recording.video import frame_rate


class RecordVideo(Filming, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Record videos of chosen episodes.

    Arguments, names of files and what is recorded when are those of `gymnasium.wrappers.RecordVideo`, which this can
    replace. What differs is what is in the videos: all frames that the emulator plays, those inside a frame skip and
    the no-ops of a reset too, whichever wrappers have them played; the console's frame rate; its 2:1 pixels; its
    sound. They are written while they are played, and `render_mode` does not matter.

    What the environment returns does not change. For sound, its emulator is replaced by one that makes it; snapshots
    of the one do not fit the other, unless `make_sound` of that environment is called too, or sound=False is given.

    Args:
        env: an `AtariEnv`, in any wrappers.
        video_folder: where the videos go; it is made.
        episode_trigger: whether to record an episode, by its number from 0 on. Without triggers it is Gymnasium's:
            episodes 0, 1, 8, 27, ... 1000, and every 1000th.
        step_trigger: whether to begin a recording with a step, by its number over all episodes.
        video_length: steps in a video, over several episodes if need be; 0 is to the end of the episode.
        name_prefix: of the files, "{name_prefix}-episode-{number}.mp4" or "{name_prefix}-step-{number}.mp4".
        fps: frames a second; None is the console's. Another number makes slow or fast motion, and the sound lower or
            higher.
        disable_logger, gc_trigger: for code written for Gymnasium's wrapper; nothing is logged, or left to collect.
        format: "mp4", "mkv", "webm", "gif" or "png", see `VideoWriter`. With "png" a video is a folder.
        scale: a pixel becomes `2 * scale` x `scale` pixels of the video.
        sound: record the sound, if the format has it. Each frame costs some microseconds more, recorded or not.
        overlay: what is written beneath the picture: some of "score", "action" and "ram".

    Raises:
        TypeError: the environment is no `AtariEnv`, or an argument is of the wrong kind.
        ValueError: an argument is out of range.
        OSError: the folder cannot be made or written to.

    If a video cannot be written any more, as on a full disk, it ends, and the *next* call of `step`, `reset` or
    `close` raises an `OSError` before it does anything. The environment can go on from there.
    """

    def __init__(
        self,
        env: gymnasium.Env[Any, Any],
        video_folder: str | os.PathLike[str],
        episode_trigger: Trigger | None = None,
        step_trigger: Trigger | None = None,
        video_length: int = 0,
        name_prefix: str = "rl-video",
        fps: float | None = None,
        disable_logger: bool = True,
        gc_trigger: Callable[[int], bool] | None = None,
        *,
        format: str = "mp4",
        scale: int = 2,
        sound: bool = True,
        overlay: tuple[str, ...] | None = None,
    ) -> None:
        RecordConstructorArgs.__init__(
            self,
            video_folder=video_folder,
            episode_trigger=episode_trigger,
            step_trigger=step_trigger,
            video_length=video_length,
            name_prefix=name_prefix,
            fps=fps,
            disable_logger=disable_logger,
            gc_trigger=gc_trigger,
            format=format,
            scale=scale,
            sound=sound,
            overlay=overlay,
        )
        inner = getattr(env, "unwrapped", env)
        if not isinstance(inner, AtariEnv):
            other = "RecordVectorVideo" if isinstance(inner, VectorEnv) else "gymnasium.wrappers.RecordVideo"
            raise TypeError(f"RecordVideo films an atari.AtariEnv, got {type(inner).__name__}; for that use {other}")
        super().__init__(env)
        self._atari = inner
        rate = frame_rate(inner.game) if fps is None else fps
        self._shot = Shot(format, inner.game.screen.shape, rate, scale, sound, overlay)
        self._schedule = Schedule(episode_trigger, step_trigger, video_length, name_prefix)
        self.video_folder = make_folder(video_folder)
        if self._shot.sound:
            inner.make_sound()
        self._watch()

    def _watch(self) -> None:
        self._set_up_camera()
        self._atari.observers.append(Observer(self._atari, self._camera))

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment, end the video of the last episode, and perhaps begin another."""
        self._camera.raise_trouble()
        self._before_episode()
        result = self.env.reset(seed=seed, options=options)
        self._schedule.episode_id += 1
        if self.recording and not self._camera.frames:  # the reset played nothing, as after a lost life
            self._camera.take(self._atari.core)
        self._count()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play a step, and film its frames."""
        self._camera.raise_trouble()
        self._before_step()
        result = self.env.step(action)
        self._schedule.step_id += 1
        self._count()
        return result

    def __getstate__(self) -> dict[str, Any]:
        """A copy counts on, but records only from its next trigger on."""
        return {name: value for name, value in vars(self).items() if name not in ("_camera", "_finalizer")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._watch()


class Observer:
    """Has a camera film every frame of an environment."""

    def __init__(self, env: AtariEnv, camera: Camera) -> None:
        self._env, self._camera = env, camera

    def game_begun(self) -> None:
        """Film the first screen of a game."""
        self._camera.begin_game()
        self._camera.take(self._env.core)

    def frame_played(self, action: int, reward: int) -> None:
        """Film a frame."""
        self._camera.take(self._env.core, action, reward)
