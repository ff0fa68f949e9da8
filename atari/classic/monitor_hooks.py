"""`MonitorHooks`: what a monitor does around `reset` and `step`, in methods that subclasses replace; `EnvMonitor`.

The files are those of Gym's Monitor. A folder has, for each monitor that wrote to it, a manifest, statistics of all
episodes (`*.stats.json`) and some videos, each with a `*.meta.json`. Their names share the numbers of the monitor and
of the process, which scripts expect.
"""

import atexit
import json
import os
import threading
import weakref
from collections.abc import Callable
from typing import Any, Literal

import atari
from atari.classic import error
from atari.classic.monitor_files import (
    FILE_PREFIX,
    atomic_write,
    capped_cubic_video_schedule,
    clear_monitor_files,
    detect_monitor_files,
    disable_videos,
    json_encode_np,
)
from atari.classic.stats_recorder import StatsRecorder
from atari.classic.video_recorder import VideoRecorder

VideoCallable = Callable[[int], bool]

_TYPES = {"training": "t", "evaluation": "e"}


class Closer:
    """Closes the registered objects that are still there when the interpreter exits.

    An object registers itself, unregisters itself in its `close`, and calls `close` in its `__del__`.

    Args:
        atexit_register: False leaves it to the script to call `close`.
    """

    def __init__(self, atexit_register: bool = True) -> None:
        self.lock = threading.Lock()
        self.next_id = -1
        self.closeables: weakref.WeakValueDictionary[int, Any] = weakref.WeakValueDictionary()
        if atexit_register:
            atexit.register(self.close)

    def generate_next_id(self) -> int:
        """A number that no other object of this closer has."""
        with self.lock:
            self.next_id += 1
            return self.next_id

    def register(self, closeable: Any) -> int:
        """Close an object at exit; returns its number for `unregister`.

        Raises:
            TypeError: it has no `close`.
        """
        if not callable(getattr(closeable, "close", None)):
            raise TypeError(f"a Closer closes objects that have a method close(), got {closeable!r}")
        number = self.generate_next_id()
        self.closeables[number] = closeable
        return number

    def unregister(self, id: int) -> None:
        """Forget the object of a number; without effect if it is gone."""
        self.closeables.pop(id, None)

    def close(self) -> None:
        """Close all objects, in the order in which they were registered."""
        for _, closeable in sorted(self.closeables.items(), key=lambda item: item[0]):
            closeable.close()


monitor_closer = Closer()
"""Closes the monitors that are open when the interpreter exits."""


class MonitorHooks:
    """The hooks of a monitor before and after a reset and a step.

    The owner calls `_before_reset`, `_after_reset`, `_before_step` and `_after_step`, and `_finish` at the end.

    Attributes:
        env: the environment.
        directory: the folder of the files.
        stats_recorder: the statistics. A subclass may assign another one in its `_start`.
        video_recorder: the recorder of the present episode; it is disabled if `_video_enabled` returned False.
        episode_id: the number of resets.
        videos: the path of each video and that of its description.
        enabled: False after the end.
    """

    env: Any

    def __init__(self, env: Any) -> None:
        self.env = env
        self.videos: list[tuple[str, str]] = []
        self.stats_recorder: Any = None
        self.video_recorder: VideoRecorder | None = None
        self.enabled = False
        self.episode_id = 0
        self._monitor_id: int | None = None
        self.env_semantics_autoreset = env.metadata.get("semantics.autoreset")

    def _start(
        self,
        directory: str | os.PathLike[str],
        video_callable: VideoCallable | Literal[False] | None = None,
        force: bool = False,
        resume: bool = False,
        write_upon_reset: bool = False,
        uid: str | None = None,
        mode: Literal["training", "evaluation"] | None = None,
    ) -> None:
        """Prepare the folder and begin to record; it takes the arguments of `Monitor`."""
        if mode is not None:
            _type_of(mode)
        if video_callable not in (None, False) and not callable(video_callable):
            raise error.Error(
                f"video_callable is a function of the episode's number, None or False, got {video_callable!r}"
            )
        self.directory = os.path.abspath(directory)
        _prepare(self.directory, force, resume)
        chosen = disable_videos if video_callable is False else video_callable or capped_cubic_video_schedule
        self.video_callable: VideoCallable = chosen
        self._monitor_id = monitor_closer.register(self)
        self.enabled = True
        self.file_prefix = FILE_PREFIX
        self.file_infix = f"{self._monitor_id}.{uid or os.getpid()}"
        self.stats_recorder = StatsRecorder(
            self.directory,
            f"{self.file_prefix}.episode_batch.{self.file_infix}",
            autoreset=bool(self.env_semantics_autoreset),
            env_id=self.env.spec.id if self.env.spec else "(unknown)",
        )
        self.write_upon_reset = write_upon_reset
        if mode is not None:
            self._set_mode(mode)

    def _set_mode(self, mode: Literal["training", "evaluation"]) -> None:
        """Record the next episodes as training or evaluation."""
        self.stats_recorder.type = _type_of(mode)

    def _before_step(self, action: Any) -> None:
        if self.enabled:
            self.stats_recorder.before_step(action)

    def _after_step(self, observation: Any, reward: Any, done: bool, info: dict[str, Any]) -> bool:
        """Record a step; returns `done`."""
        if not self.enabled:
            return done
        if done and self.env_semantics_autoreset:  # the observation is the first of the next episode
            self.reset_video_recorder()
            self.episode_id += 1
            self._flush()
        self.stats_recorder.after_step(observation, reward, done, info)
        if self.video_recorder is not None:
            self.video_recorder.capture_frame()
        return done

    def _before_reset(self) -> None:
        if self.enabled:
            self.stats_recorder.before_reset()

    def _after_reset(self, observation: Any) -> None:
        """Begin to record an episode."""
        if not self.enabled:
            return
        self.stats_recorder.after_reset(observation)
        self._reset_video_recorder()
        self.episode_id += 1
        self._flush()

    def reset_video_recorder(self) -> None:
        """End the video of the last episode, and begin that of the next if `_video_enabled` returns true."""
        if self.video_recorder is not None:
            self._close_video_recorder()
        name = f"{self.file_prefix}.video.{self.file_infix}.video{self.episode_id:06}"
        enabled = bool(self._video_enabled())
        self.video_recorder = VideoRecorder(
            env=self.env,
            base_path=os.path.join(self.directory, name),
            metadata={"episode_id": self.episode_id},
            enabled=enabled and bool({"rgb_array", "ansi"} & set(self.env.metadata.get("render.modes", ()))),
        )
        self.video_recorder.capture_frame()

    def _reset_video_recorder(self) -> None:  # its name in 2017
        self.reset_video_recorder()

    def _close_video_recorder(self) -> None:
        recorder = self.video_recorder
        assert recorder is not None
        recorder.close()
        if recorder.functional:
            self.videos.append((recorder.path, recorder.metadata_path))

    def _video_enabled(self) -> bool:
        """Whether the next episode, `episode_id`, is recorded."""
        return self.video_callable(self.episode_id)

    def _env_info(self) -> dict[str, Any]:
        """The facts of the environment in the manifest."""
        spec = self.env.spec
        return {"gym_version": f"atari-envs {atari.__version__}", "env_id": spec and spec.id}

    def _flush(self, force: bool = False) -> None:
        """Write the statistics and the manifest, with `force` or if they are written after each reset."""
        if not self.write_upon_reset and not force:
            return
        self.stats_recorder.flush()
        manifest = {
            "stats": os.path.basename(self.stats_recorder.path),
            "videos": [tuple(map(os.path.basename, video)) for video in self.videos],
            "env_info": self._env_info(),
        }
        name = f"{self.file_prefix}.manifest.{self.file_infix}.manifest.json"
        with atomic_write(os.path.join(self.directory, name)) as file:
            json.dump(manifest, file, default=json_encode_np)

    def _finish(self) -> None:
        """Write the files; later calls do nothing."""
        if not self.enabled:
            return
        self.enabled = False
        self.stats_recorder.close()
        if self.video_recorder is not None:
            self._close_video_recorder()
        self._flush(force=True)
        assert self._monitor_id is not None
        monitor_closer.unregister(self._monitor_id)

    def close(self) -> None:
        """See `_finish`."""
        self._finish()


class EnvMonitor:
    """`env.monitor`, with `start(directory)` and `close()`, as in 2016, before `Monitor` was a wrapper.

    Between `start` and `close`, the methods of this class replace the instance's `step` and `reset`. They call the
    methods of the environment's class and record.
    """

    def __init__(self, env: Any) -> None:
        self._env = env
        self._hooks: MonitorHooks | None = None

    def start(self, directory: str | os.PathLike[str], *, seed: int | None = None, **options: Any) -> None:
        """Begin to record, after seeding the environment if `seed` is given; `options` are options of `Monitor`.

        Raises:
            gymnasium.error.Error: it records already, or see `Monitor`.
        """
        if self._hooks is not None:
            raise error.Error("env.monitor is started already; call env.monitor.close() first")
        if seed is not None:
            self._env.seed(seed)
        hooks = MonitorHooks(self._env)
        hooks._start(directory, **options)
        self._hooks = hooks
        env, kind = self._env, type(self._env)

        def step(action: Any) -> tuple[Any, Any, bool, dict[str, Any]]:
            hooks._before_step(action)
            observation, reward, done, info = kind.step(env, action)
            return observation, reward, hooks._after_step(observation, reward, done, info), info

        def reset(**options: Any) -> Any:
            hooks._before_reset()
            observation = kind.reset(env, **options)
            hooks._after_reset(observation)
            return observation

        vars(env).update(step=step, reset=reset)

    def close(self) -> None:
        """Write the files, and stop recording."""
        hooks, self._hooks = self._hooks, None
        if hooks is not None:
            del vars(self._env)["step"], vars(self._env)["reset"]
            hooks.close()


def _type_of(mode: str) -> str:
    if mode not in _TYPES:
        raise error.Error(f"mode must be 'training' or 'evaluation', got {mode!r}")
    return _TYPES[mode]


def _prepare(directory: str, force: bool, resume: bool) -> None:
    os.makedirs(directory, exist_ok=True)
    if force:
        clear_monitor_files(directory)
        return
    written = detect_monitor_files(directory)
    if written and not resume:
        raise error.Error(
            f"{directory} has files of another Monitor, such as {os.path.basename(written[0])}; use another folder, "
            "force=True to remove them, or resume=True to add to them"
        )
