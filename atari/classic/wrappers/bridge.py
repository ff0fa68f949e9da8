"""`Bridge`: a wrapper written for Gymnasium, around an environment of the old interface."""

from collections.abc import Callable
from typing import Any

import gymnasium

from atari.classic.adapter import Adapter
from atari.classic.core import Env, Step, Wrapper
from atari.classic.modern import Modern

_GymnasiumEnv = gymnasium.Env[Any, Any]


class Bridge(Wrapper):
    """An old-style environment, inside a wrapper of Gymnasium.

    Args:
        env: the environment.
        wrap: puts Gymnasium's wrapper around an environment of Gymnasium's interface.
    """

    def __init__(self, env: Env, wrap: Callable[[_GymnasiumEnv], _GymnasiumEnv]) -> None:
        super().__init__(env)
        self._wrapped = Adapter(wrap(_Inside(env)))
        self.action_space = self._wrapped.action_space
        self.observation_space = self._wrapped.observation_space

    def _reset(self, **options: Any) -> Any:
        return self._wrapped.reset()

    def _step(self, action: Any) -> Step:
        return self._wrapped.step(action)


class _Inside(Modern):
    """The environment with Gymnasium's interface; `unwrapped` is the Gymnasium environment inside an `Adapter`."""

    @property
    def unwrapped(self) -> _GymnasiumEnv:
        inside = self.classic.unwrapped
        return inside.modern.unwrapped if isinstance(inside, Adapter) else self
