"""`access`: reads and writes the RAM of a core, of an environment, or of the lanes of a vector."""

import reprlib
from typing import Any

import gymnasium
import numpy as np

from atari.base.validation import check_integer
from atari.cores import Core
from atari.env import AtariEnv
from atari.games.game import Game
from atari.lab.labels import ByteArray
from atari.vector import AtariVectorEnv


def access(target: Any, index: int | None = None) -> "_Single | _Vector":
    """The access to an environment or a wrapper around one, to a core, or to a vector or its lane `index`.

    An access has the `games` of its lanes. `single` is true for a core, an environment and one lane. `read` returns a
    copy of RAM, (lanes, 128) uint8, and `write` changes one byte.

    Raises:
        TypeError: `target` is something else, or `index` is given for something that is no vector.
        IndexError: there is no such lane.
    """
    inner: Any = target.unwrapped if isinstance(target, (gymnasium.Env, gymnasium.vector.VectorEnv)) else target
    if isinstance(inner, AtariVectorEnv):
        lanes = list(range(inner.num_envs)) if index is None else [_check_index(inner, index)]
        return _Vector(inner, lanes, single=index is not None)
    if index is not None:
        raise TypeError(f"index is the number of a lane of an AtariVectorEnv, but this is {target!r}; leave it out")
    if isinstance(inner, AtariEnv) or (isinstance(getattr(inner, "game", None), Game) and hasattr(inner, "set_ram")):
        return _Single(inner)
    advice = "for a replay or its frames, take Ram(replay.seek(number of frames))"
    if isinstance(inner, gymnasium.vector.VectorEnv):
        advice = "take one environment of another vector"
    raise TypeError(
        "RAM is read from an AtariEnv (or a wrapper around one), a core, or an AtariVectorEnv, got "
        f"{reprlib.repr(target)}; {advice}"
    )


def _check_index(envs: AtariVectorEnv, index: Any) -> int:
    try:
        return check_integer("index", index, 0, envs.num_envs - 1)
    except ValueError as error:
        raise IndexError(f"{error}; the vector has {envs.num_envs} lanes") from None


class _Single:
    """An environment or a core. An environment may replace its core by another one, so the core is read at each use."""

    single = True

    def __init__(self, player: Any) -> None:
        self._player = player
        self.games: tuple[Game, ...] = (player.game,)

    def _core(self) -> Core:
        if not isinstance(self._player, AtariEnv):
            core: Core = self._player
            return core
        if self._player.driver.closed:
            raise gymnasium.error.ClosedEnvironmentError("this environment is closed; call reset() to go on")
        return self._player.core

    def read(self) -> ByteArray:
        return self._core().ram()[None]

    def write(self, _row: int, index: int, byte: int) -> None:
        self._core().set_ram(index, byte)


class _Vector:
    """These lanes of a vector."""

    def __init__(self, envs: AtariVectorEnv, lanes: list[int], single: bool) -> None:
        self._envs, self._lanes, self.single = envs, np.array(lanes), single
        self.games = tuple(envs.games[lane] for lane in lanes)

    def read(self) -> ByteArray:
        return self._envs.ram(self._lanes)

    def write(self, row: int, index: int, byte: int) -> None:
        self._envs.lanes[self._lanes[row]].set_ram(index, byte)
