"""`env.monitor.start(directory)` and `env.monitor.close()`, as in 2016, before `Monitor` was a wrapper."""

from os import PathLike
from typing import Any, Protocol

from atari.classic import error
from atari.classic.monitor_hooks import Monitored, MonitorHooks


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
        self._hooks: MonitorHooks | None = None

    def start(self, directory: str | PathLike[str], *, seed: int | None = None, **options: Any) -> None:
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
        env: Any = self._env
        kind = type(env)

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
