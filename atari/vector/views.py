"""`Views`: a vector environment as images, and as other libraries see it."""

import math
from typing import Any

import gymnasium

from atari import _emulator
from atari.cores import ByteArray
from atari.notebook import picture, png
from atari.rendering import tile
from atari.vector.ale_interface import AleVectorInterface
from atari.vector.options import VectorOptions

_MOST_SHOWN = 36  # screens in a notebook


class Views:
    """Methods of `AtariVectorEnv` that show it as images, to JAX, PyTorch and users of ale-py's interface."""

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
        """The screens as one image, (height, width, 3) uint8, of as many columns of screens as rows, or one more."""
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

    def _repr_html_(self) -> str | None:
        """The first screens as one picture, for a notebook; None while they are played, and after `close`."""
        try:
            screens = self._screens(_MOST_SHOWN)
        except (RuntimeError, gymnasium.error.ClosedEnvironmentError):
            return None
        games, number = self._options.games, len(self._options.games)
        image = tile(screens, min(6, math.ceil(math.sqrt(len(screens)))))
        titles = ", ".join(dict.fromkeys(game.title for game in games))
        first = f", the first {_MOST_SHOWN}" if number > _MOST_SHOWN else ""
        return picture(
            png(image), f"{number} environments: {titles}{first}", width=image.shape[1], height=image.shape[0]
        )

    def xla(self, *, callback: bool | None = None) -> Any:
        """`(handle, recv, send, step)` for functions compiled by JAX, as EnvPool's (added).

        `step(handle, action, env_id=None)` returns a handle and what `step` returns; `send(handle, action,
        env_id=None)`, a handle; `recv(handle)`, a handle and results. Pass on each handle: their chain is the order in
        which calls run. `env_id` must have as many rows as a batch. Reset the environments by `reset`, or `reset_async`
        before `recv`. Compiled functions fail when the environments have been closed, or have gone.

        Results are those of `step` to the byte, with `info` of the same arrays in each step: without the masks of
        keys that all rows have, and without `episode`; in SAME_STEP always with `final_obs` and `final_info`, zero
        where nothing ended, and their masks.

        Args:
            callback: False plays by calls from XLA to the emulator without Python, on the CPU; True by ordered
                callbacks in Python, on any device; None is the former if JAX's default device is a CPU.

        Returns:
            A named tuple; `handle` is uint8 (8,).

        Raises:
            gymnasium.error.DependencyNotInstalled: JAX is not installed, or is older than 0.5.0.
            gymnasium.error.ClosedEnvironmentError: the environments are closed.
            TypeError, ValueError: `callback` is no bool, or `continuous` or `agent_indicator` is on.

        Example:
            >>> handle, recv, send, step = envs.xla()
            >>> _ = envs.reset(seed=0)
            >>> handle, (obs, reward, terminated, truncated, info) = jax.jit(step)(handle, actions)
        """
        from atari.integrations import jax

        with self._lock:
            engine = self._open()
            if self._port is None:
                image, ram = (name != "none" for name in self._options.part_names())
                self._port = _emulator.XlaPort(engine, image, ram)
            return jax.xla(self, self._options, self._port, callback)

    def torch(self, device: Any = None) -> Any:
        """The same environments with PyTorch tensors (added): a `atari.integrations.torch.TorchEnvs`.

        Args:
            device: where observations, rewards and ends are; None is the CPU, where they share the memory of the
                arrays. To a CUDA device they are copied from page-locked memory, while Python goes on.

        Raises:
            gymnasium.error.DependencyNotInstalled: PyTorch is not installed.
            RuntimeError: PyTorch has no such device.

        Example:
            >>> envs = atari.AtariVectorEnv("pong", 8).torch("cuda")
            >>> obs, info = envs.reset(seed=0)
            >>> obs, reward, terminated, truncated, info = envs.step(policy(obs).argmax(1))
        """
        from atari.integrations.torch import TorchEnvs

        return TorchEnvs(self, device)
