"""Helpers of the tests of `AtariEnv`: start a game, play at random, compare results."""

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import ale_py
import gymnasium
import numpy as np
import pytest
from gymnasium.utils import env_checker

from atari import AtariEnv
from atari.cores import ale

needs_gymnasium_1 = pytest.mark.skipif(gymnasium.__version__ < "1", reason="compares with Gymnasium 1.0 or newer")
needs_autoreset_modes = pytest.mark.skipif(
    not hasattr(gymnasium.vector, "AutoresetMode"), reason="compares with the modes of Gymnasium 1.1 or newer"
)
OLD_ALE_PY = ale._numbers(ale_py.__version__) < ale._numbers(ale.OLDEST_ALE_PY)
needs_new_ale_py = pytest.mark.skipif(OLD_ALE_PY, reason="the installed ale-py is too old for AleCore")
_EXACT = {"exact": True} if "exact" in inspect.signature(env_checker.data_equivalence).parameters else {}


def data_equivalence(mine: Any, theirs: Any) -> bool:
    """Gymnasium's function with exact equality; that of Gymnasium 0.29 accepts a difference of 1e-5."""
    return bool(env_checker.data_equivalence(mine, theirs, **_EXACT))


@contextmanager
def unchanged(env: AtariEnv) -> Iterator[None]:
    """Check that the block, which is expected to raise, leaves the environment unchanged."""
    before = env.snapshot()
    yield
    assert env.snapshot() == before


class AroundAle:
    """An object that users put around `env.ale`: it has the methods of the one inside."""

    def __init__(self, ale: Any) -> None:
        self.inner = ale

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)


class Observer:
    """Keeps a value of each frame that the console plays, and of each game that begins if `begun` makes one."""

    def __init__(self, env: Any, frame: Callable[[int, int], Any], begun: Callable[[], Any] | None = None) -> None:
        self.seen: list[Any] = []
        self._frame, self._begun = frame, begun
        env.unwrapped.driver.observers.append(self)

    def game_begun(self) -> None:
        if self._begun is not None:
            self.seen.append(self._begun())

    def frame_played(self, action: int, reward: int) -> None:
        self.seen.append(self._frame(action, reward))

    def take(self) -> list[Any]:
        """What was kept since the last call."""
        taken, self.seen = self.seen, []
        return taken


def started(game: str = "breakout", *, seed: int = 0, **options: Any) -> AtariEnv:
    env = AtariEnv(game, **options)
    env.reset(seed=seed)
    return env


def playing(**options: Any) -> AtariEnv:
    """A game of Pong whose ball is in play."""
    env = started("pong", **options)
    for _ in range(30):
        env.step(2)  # RIGHT
    return env


def over(env: AtariEnv) -> AtariEnv:
    """The game of Breakout with its last ball lost."""
    env.core.set_ram(0x39, 0)
    env.step(0)
    return env


def play(env: gymnasium.Env[Any, Any], steps: int, seed: int = 0) -> list[tuple[Any, ...]]:
    rng = np.random.default_rng(seed)
    actions = [int(action) for action in rng.integers(4, size=steps)]
    return [comparable(env.step(action)) for action in actions]


def comparable(result: tuple[Any, ...]) -> tuple[Any, ...]:
    observation, *rest = result
    pixels = observation if isinstance(observation, dict) else {"image": observation}
    return ({key: value.tobytes() for key, value in pixels.items()}, *rest)
