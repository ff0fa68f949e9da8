"""`RecordVideo`: Gymnasium's wrapper of this name, with every emulated frame, the console's frame rate and sound."""

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, overload

import gymnasium

from atari.base.gymnasium_versions import VectorEnv
from atari.base.validation import check_arguments
from atari.env import AtariEnv
from atari.env.restorable import RestorableWrapper
from atari.recording.recordable import not_recorded
from atari.recording.video.record_vector_video import RecordVectorVideo
from atari.recording.video.record_video_base import RecordVideoBase, Trigger, VideoRecorder, VideoSettings, make_folder
from atari.recording.video.writer import video_rate
from atari.vector.env import is_vector


class RecordEnvVideo(RecordVideoBase, RestorableWrapper):
    """Records videos of an `AtariEnv`: `RecordVideo(env, video_folder, ...)` makes it."""

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
        speed: float = 1,
        scale: int = 2,
        sound: bool = True,
        overlay: tuple[str, ...] | None = None,
        keep: str = "all",
    ) -> None:
        given = {name: value for name, value in locals().items() if name not in ("self", "env", "__class__")}
        inner = getattr(env, "unwrapped", env)
        if not isinstance(inner, AtariEnv):
            raise not_recorded(env, "RecordVideo", "; for other environments use gymnasium.wrappers.RecordVideo")
        super().__init__(env, **given)
        self._atari = inner
        rate = video_rate(inner.game, f".{format}", fps, speed)
        self._settings = VideoSettings(format, inner.game, inner.game.screen.shape, rate, scale, sound, overlay, keep)
        self._plan(episode_trigger, step_trigger, video_length, name_prefix)
        self.disable_logger, self.gc_trigger = disable_logger, gc_trigger
        self.video_folder = make_folder(video_folder, name_prefix)
        if self._settings.sound:
            inner.driver.make_sound()
        self._watch()

    def _watch(self) -> None:
        inner = self._atari  # the recorder must not refer to this wrapper, which ends the video when it is collected
        self._make_recorder(lambda: inner.task)
        self._atari.driver.observers.append(FrameWriter(self._atari, self._recorder))

    @property
    def render_history(self) -> list[Any]:
        """The screens that the next `render` returns, with the render mode "rgb_array_list"."""
        return list(self._atari.recent_screens)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset the environment, end the last episode's video, and begin one if a trigger selects it."""
        self._recorder.raise_deferred_error()
        self._before_episode()
        result = self.env.reset(seed=seed, options=options)
        self.episode_id += 1
        if self.recording and not self._recorder.frames:  # the reset played nothing, as after a lost life
            self._recorder.write_frame(self._atari.core)
        self._count()
        return result

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Play a step and record its frames."""
        self._recorder.raise_deferred_error()
        self._before_step()
        result = self.env.step(action)
        self.step_id += 1
        self._count()
        return result


class RecordVideo(RecordEnvVideo):
    """Records videos of chosen episodes.

    `gymnasium.wrappers.RecordVideo` has the same arguments and file names and records the same episodes, and so has
    `gymnasium.wrappers.vector.RecordVideo` for a vector. The videos differ: they have every emulated frame, also the
    frames inside a frame skip and the no-ops of a reset, whichever wrapper plays them. They have the console's frame
    rate, its 2:1 pixels and its sound. Frames are written while they are played, and `render_mode` has no effect.
    `video_facts` reads the task that was played from a file.

    The environment's results do not change. For sound, the environment's core is replaced by a core with sound. A
    snapshot of an environment with sound fits only environments with sound: call `unwrapped.driver.make_sound()` of
    the other environment, or pass sound=False here.

    Args:
        env: an `AtariEnv`, in any wrappers; or an `AtariVectorEnv` with batches of all environments, in any
            wrappers. A vector has these arguments, too: after `video_folder`, `video_aspect_ratio`,
            (width, height), is the approximate ratio of the mosaic's sides, and `record_first_only` (False) films only
            environment `index`; by name, `index` is the environment whose episodes are counted and whose sound and
            overlay are recorded.
        video_folder: the folder of the videos; it is created.
        episode_trigger: returns whether to record an episode, by its number from 0. Without triggers it is
            Gymnasium's: episodes 0, 1, 8, 27, ... 1000, and every 1000th.
        step_trigger: returns whether to begin a video at a step, by its number over all episodes.
        video_length: steps in a video, which may span episodes, but ends where a trigger begins the next video; 0 ends
            the video with the episode.
        name_prefix: the start of the names "{name_prefix}-episode-{number}.mp4" and "{name_prefix}-step-{number}.mp4".
        fps: frames a second; None is the console's rate times `speed`.
        disable_logger: False prints the path of each complete video.
        gc_trigger: returns whether to collect garbage after a video, by the number of the episode.
        format: "mp4", "mkv", "webm", "gif" or "png", see `VideoWriter`. With "png" a video is a folder.
        speed: 0.25 is slow motion, and 4 is fast, within 0.05..16; see `VideoWriter`. The sound is lower or higher.
        scale: a pixel becomes `2 * scale` x `scale` pixels of the video.
        sound: record the sound, if the format has it. Each frame costs some microseconds more, recorded or not.
        overlay: parts of the text below the frame: some of "score", "lives", "action", "ram" and "curve", the score of
            the game so far.
        keep: "all" videos, or only the "best" so far, which has the highest sum of rewards without clipping.

    Attributes:
        episode_trigger, step_trigger, video_length, name_prefix: as in Gymnasium. They can be set, and apply to the
            videos that begin from then on.
        frames_per_sec, video_folder, gc_trigger, disable_logger: likewise.
        recording, episode_id, step_id: whether a video is open, and the numbers of the episode and of the last step.
        recorded_frames: has the length of the open video; the frames are in the file.

    Raises:
        TypeError: the environment is another one, or an argument has the wrong type.
        ValueError: an argument is out of range, or a vector has smaller batches.
        OSError: the folder cannot be created or written to.

    If a video cannot be written any more, for example because the disk is full, the video ends. The error is deferred:
    the *next* call of `step`, `reset` or `close` raises it as an `OSError` before it changes anything. The environment
    can continue from there.

    Example:
        >>> import os
        >>> import atari
        >>> from atari.recording import RecordVideo
        >>> with RecordVideo(atari.make("pong"), "videos", episode_trigger=lambda episode: episode == 0) as env:
        ...     observation, info = env.reset(seed=0)
        ...     for _ in range(10):
        ...         observation = env.step(0)[0]
        >>> os.listdir("videos")
        ['rl-video-episode-0.mp4']
    """

    if TYPE_CHECKING:  # at run time `typing` would hold the functions, and all modules, until the process has ended

        @overload
        def __new__(
            cls,
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
            speed: float = 1,
            scale: int = 2,
            sound: bool = True,
            overlay: tuple[str, ...] | None = None,
            keep: str = "all",
        ) -> "RecordVideo": ...
        @overload
        def __new__(  # type: ignore[misc]
            cls, env: VectorEnv, video_folder: str | os.PathLike[str], *args: Any, **options: Any
        ) -> RecordVectorVideo: ...

    def __new__(cls, env: Any = None, *args: Any, **kwargs: Any) -> Any:
        """A `RecordVectorVideo` of a vector; copying calls this without arguments."""
        kind: type = RecordVectorVideo if is_vector(env) else RecordEnvVideo
        check_arguments("RecordVideo", kind, kwargs)
        return RecordVectorVideo(env, *args, **kwargs) if kind is RecordVectorVideo else super().__new__(cls)


class FrameWriter:
    """An observer of an environment that writes each frame to a `VideoRecorder`."""

    def __init__(self, env: AtariEnv, recorder: VideoRecorder) -> None:
        self._env, self._recorder = env, recorder

    def game_begun(self) -> None:
        """Record the first screen of a game."""
        self._recorder.begin_game()
        self._recorder.write_frame(self._env.core)

    def frame_played(self, action: int, reward: int) -> None:
        """Record a frame."""
        self._recorder.write_frame(self._env.core, action, reward)
