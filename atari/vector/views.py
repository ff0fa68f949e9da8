"""`Views`: a vector environment as images, and for other libraries."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import atari._emulator as _emulator
from atari.base.notebook import MOST_SHOWN, picture
from atari.base.png import png
from atari.cores import ByteArray
from atari.env.rendering import tile
from atari.games.actions import actions_by_motion
from atari.vector.ale_interface import AleVectorInterface
from atari.vector.options import VectorOptions


class Views:
    """Methods of `AtariVectorEnv` that show it as images, and to users of its engine and of ale-py's interface."""

    num_envs: int
    render_mode: Any
    _lock: Any
    _open: Any
    _options: VectorOptions
    _port: _emulator.XlaPort | None

    def render(self) -> tuple[ByteArray, ...] | None:
        """The screens of all environments, (height, 160, 3) uint8 each; None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(self._screens())

    def mosaic(self) -> ByteArray:
        """The screens as one image, (height, width, 3) uint8, with as many columns of screens as rows, or one more."""
        screens = self._screens()
        return tile(screens, math.ceil(math.sqrt(len(screens))))

    def _screens(self, most: int | None = None) -> list[ByteArray]:
        with self._lock:
            engine = self._open()
            return [engine.screen_rgb(index) for index in range(self.num_envs)[:most]]

    @property
    def ale(self) -> AleVectorInterface:
        """The environments under the method names of ale-py's `ALEVectorInterface`."""
        envs: Any = self
        return AleVectorInterface(envs)

    @property
    def map_action_idx(self) -> NDArray[np.int64]:
        """ALE's numbers of the actions, (3, 3, 2): by LEFT, neither, RIGHT; by DOWN, neither, UP; and by FIRE."""
        return actions_by_motion()

    @property
    def is_xla_registered(self) -> bool:
        """Whether `atari.integrations.jax.xla` was called."""
        return self._port is not None

    def _repr_html_(self) -> str | None:
        """The first screens as one image, for a notebook; None while they are played, and after `close`."""
        try:
            screens = self._screens(MOST_SHOWN)
        except (RuntimeError, gymnasium.error.ClosedEnvironmentError):
            return None
        games, number = self._options.games, len(self._options.games)
        image = tile(screens, min(6, math.ceil(math.sqrt(len(screens)))))
        titles = ", ".join(dict.fromkeys(game.title for game in games))
        first = f", the first {MOST_SHOWN}" if number > MOST_SHOWN else ""
        return picture(png(image), f"{number} environments: {titles}{first}", image.shape)

    @contextmanager
    def engine(self) -> Iterator[_emulator.VectorEngine]:
        """The engine, for extensions of this class (added). Calls of other threads wait until the block ends.

        Raises:
            gymnasium.error.ClosedEnvironmentError: the environments are closed.
        """
        with self._lock:
            yield self._open()

    def xla_port(self) -> _emulator.XlaPort:
        """The engine for functions compiled by XLA (added); `close` closes it too.

        Raises:
            gymnasium.error.ClosedEnvironmentError: the environments are closed.
        """
        with self.engine() as engine:
            if self._port is None:
                image, ram = (name != "none" for name in self._options.part_names())
                self._port = _emulator.XlaPort(engine, image, ram)
            return self._port
