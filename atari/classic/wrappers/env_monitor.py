"""`env.monitor.start(directory)` and `env.monitor.close()`, as in 2016, before `Monitor` was a wrapper."""

from os import PathLike
from typing import Any

import gymnasium

from atari.classic.core import Env, Step, Wrapper
from atari.classic.wrappers.monitor import Monitor


class EnvMonitor:
    """Lets a `Monitor` watch an environment that the script goes on to call itself.

    While it does, the environment's `step` and `reset` are the monitor's.
    """

    def __init__(self, env: Env) -> None:
        self._env = env
        self._monitor: Monitor | None = None

    def start(self, directory: str | PathLike[str], *, seed: int | None = None, **options: Any) -> None:
        """Begin to watch, after seeding the environment if `seed` is given; `options` are those of `Monitor`.

        Raises:
            gymnasium.error.Error: it watches already, or as of `Monitor`.
        """
        if self._monitor is not None:
            raise gymnasium.error.Error("env.monitor is started already; call env.monitor.close() first")
        if seed is not None:
            self._env.seed(seed)
        self._monitor = Monitor(_Watched(self._env), directory, **options)
        vars(self._env).update(step=self._monitor.step, reset=self._monitor.reset)

    def close(self) -> None:
        """Write the files, and watch no more."""
        monitor, self._monitor = self._monitor, None
        if monitor is not None:
            del vars(self._env)["step"], vars(self._env)["reset"]
            monitor.close()


class _Watched(Wrapper):
    """The environment with the methods of its class, which stays open."""

    def _step(self, action: Any) -> Step:
        return type(self.env).step(self.env, action)

    def _reset(self, **options: Any) -> Any:
        return type(self.env).reset(self.env, **options)

    def _close(self) -> None:
        pass
