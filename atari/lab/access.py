"""`Access`: reads and writes the RAM of a core, of an environment, or of the environments of a vector."""

from typing import Any, Protocol

import gymnasium
import numpy as np

from atari.cores import Core
from atari.env import AtariEnv
from atari.games.game import Game
from atari.lab.labels import ByteArray
from atari.validation import check_integer
from atari.vector import AtariVectorEnv


class Access(Protocol):
    """One or several machines of which RAM can be read and written."""

    games: tuple[Game, ...]  # of each
    single: bool  # whether it is one machine, not a vector

    def read(self) -> ByteArray:
        """A copy of RAM, (machines, 128) uint8."""

    def write(self, machine: int, index: int, byte: int) -> None:
        """Write one byte."""


def access(target: Any, index: int | None = None) -> Access:
    """The access to an environment or a wrapper around one, to a core, or to a vector or its member `index`.

    Raises:
        TypeError: `target` is something else, or `index` is given for something that is no vector.
        IndexError: there is no such member.
    """
    inner: Any = target.unwrapped if isinstance(target, (gymnasium.Env, gymnasium.vector.VectorEnv)) else target
    if isinstance(inner, AtariVectorEnv):
        return _Vector(inner) if index is None else _Member(inner, _check_index(inner, index))
    if index is not None:
        raise TypeError(
            f"index is the number of an environment of an AtariVectorEnv, but this is {target!r}; leave it out"
        )
    if isinstance(inner, AtariEnv):
        return _Environment(inner)
    if isinstance(getattr(inner, "game", None), Game) and hasattr(inner, "set_ram"):
        return _Core(inner)
    raise TypeError(
        f"RAM is read from an AtariEnv (or a wrapper around one), a core, or an AtariVectorEnv, got {target!r}; "
        "of the environments of another vector, take one"
    )


def _check_index(envs: AtariVectorEnv, index: Any) -> int:
    try:
        return check_integer("index", index, 0, envs.num_envs - 1)
    except ValueError as error:
        raise IndexError(f"{error}; there are {envs.num_envs} environments") from None


class _Core:
    single = True

    def __init__(self, core: Core) -> None:
        self._core = core
        self.games: tuple[Game, ...] = (core.game,)

    def read(self) -> ByteArray:
        return self._core.ram()[None]

    def write(self, machine: int, index: int, byte: int) -> None:
        self._core.set_ram(index, byte)


class _Environment:
    """The core of an environment may be replaced by another one, so it is read at each use."""

    single = True

    def __init__(self, env: AtariEnv) -> None:
        self._env = env
        self.games: tuple[Game, ...] = (env.game,)

    def _open(self) -> Core:
        if self._env._closed_state is not None:
            raise gymnasium.error.ClosedEnvironmentError("this environment is closed; call reset() to go on")
        return self._env.core

    def read(self) -> ByteArray:
        return self._open().ram()[None]

    def write(self, machine: int, index: int, byte: int) -> None:
        self._open().set_ram(index, byte)


class _Vector:
    single = False

    def __init__(self, envs: AtariVectorEnv) -> None:
        self._envs = envs
        self.games: tuple[Game, ...] = envs.games

    def read(self) -> ByteArray:
        return self._envs.ram()

    def write(self, machine: int, index: int, byte: int) -> None:
        self._envs.members[machine].set_ram(index, byte)


class _Member:
    single = True

    def __init__(self, envs: AtariVectorEnv, index: int) -> None:
        self._envs, self._index = envs, index
        self.games: tuple[Game, ...] = (envs.games[index],)

    def read(self) -> ByteArray:
        return self._envs.ram(np.array([self._index]))

    def write(self, machine: int, index: int, byte: int) -> None:
        self._envs.members[self._index].set_ram(index, byte)
