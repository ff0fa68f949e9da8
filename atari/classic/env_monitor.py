"""`env.monitor.start(directory)` and `env.monitor.close()`, as in 2016, before `Monitor` was a wrapper."""

import atexit
from os import PathLike
from typing import Any, Protocol

import gymnasium

from atari.classic.episode_recorder import EpisodeRecorder, Monitored


class MonitoredByMethods(Monitored, Protocol):
    """The part of an environment that `EnvMonitor` needs; `atari.classic.Env` has it."""

    def step(self, action: Any) -> tuple[Any, Any, bool, dict[str, Any]]:
        """Take an action; return observation, reward, done and info."""

    def reset(self) -> Any:
        """Start an episode and return its first observation."""

    def seed(self, seed: int | None = None) -> list[int]:
        """Seed the environment."""


class EnvMonitor:
    """Records the episodes of an environment whose `step` and `reset` the script calls itself.

    Between `start` and `close`, the methods of this class replace the instance's `step` and `reset`. They call the
    methods of the environment's class and record.
    """

    def __init__(self, env: MonitoredByMethods) -> None:
        self._env = env
        self._recorder: EpisodeRecorder | None = None

    def start(self, directory: str | PathLike[str], *, seed: int | None = None, **options: Any) -> None:
        """Begin to record, after seeding the environment if `seed` is given; `options` are options of `Monitor`.

        Raises:
            gymnasium.error.Error: it records already, or see `Monitor`.
        """
        if self._recorder is not None:
            raise gymnasium.error.Error("env.monitor is started already; call env.monitor.close() first")
        if seed is not None:
            self._env.seed(seed)
        self._recorder = recorder = EpisodeRecorder(self._env, directory, **options)
        env: Any = self._env
        kind = type(env)

        def step(action: Any) -> tuple[Any, Any, bool, dict[str, Any]]:
            recorder.check_running()
            observation, reward, done, info = kind.step(env, action)
            recorder.add_step(reward, done)
            return observation, reward, done, info

        def reset(**options: Any) -> Any:
            observation = kind.reset(env, **options)
            recorder.begin_episode()
            return observation

        vars(env).update(step=step, reset=reset)
        atexit.register(self.close)

    def close(self) -> None:
        """Write the files, and stop recording."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            atexit.unregister(self.close)
            del vars(self._env)["step"], vars(self._env)["reset"]
            recorder.close()
