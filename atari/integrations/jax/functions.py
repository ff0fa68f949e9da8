"""`xla`: a vector environment's `handle`, `recv`, `send` and `step` for functions that JAX compiles."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

import atari._emulator as _emulator
from atari.base.extras import import_extra, pip_install
from atari.integrations.jax.results import ResultParts

_registered = False


class XlaFunctions(NamedTuple):
    """The functions that `xla` returns."""

    handle: Any
    recv: Callable[..., Any]
    send: Callable[..., Any]
    step: Callable[..., Any]


def xla(envs: Any, *, callback: bool | None = None) -> XlaFunctions:
    """`(handle, recv, send, step)` of an `AtariVectorEnv`, in EnvPool's form, for functions that JAX compiles.

    `step(handle, action, env_id=None)` returns a handle and the results of `step`; `send(handle, action, env_id=None)`
    returns a handle; `recv(handle)` returns a handle and results. Pass on each handle: their chain is the order in
    which calls run. `env_id` must have the number of rows of a batch. Reset the environments by `reset`, or by
    `reset_async` before `recv`. Compiled functions fail after the environments have been closed or collected.

    Results equal those of `AtariVectorEnv.step` to the byte. `info` has the same arrays in each step: it leaves out the
    masks of keys that all rows have, and `episode`. In SAME_STEP it always has `final_obs` and `final_info`, zero in
    the rows of episodes that continue, and their masks.

    Args:
        envs: the environments.
        callback: False plays by calls from XLA to the emulator without Python, on the CPU. True plays by
            callbacks in Python, on any device. None means False if JAX's default device is a CPU, otherwise True.

    Returns:
        A named tuple with these four fields; `handle` is uint8 (8,).

    Raises:
        gymnasium.error.DependencyNotInstalled: JAX is not installed, or is older than 0.5.0, which added `jax.ffi`.
        gymnasium.error.ClosedEnvironmentError: the environments are closed.
        TypeError: `callback` is neither None nor a bool.
        ValueError: the environments have `continuous` or `agent_indicator`, which compiled functions do not support.

    Example:
        >>> import atari
        >>> from atari.integrations.jax import xla
        >>> envs = atari.AtariVectorEnv("pong", 2)
        >>> handle, recv, send, step = xla(envs)
        >>> handle.shape
        (8,)
    """
    port, options = envs.xla_port(), envs.options
    need = f"xla() needs JAX 0.5.0 or newer: {pip_install('jax')}"
    jax, *_ = (import_extra(name, need) for name in ("jax", "jax.ffi", "jax.numpy"))
    if callback is not None and not isinstance(callback, bool):
        raise TypeError(f"callback must be True, False or None, got {callback!r}")
    if options.task.continuous:
        raise ValueError("xla() needs actions that are integers: leave continuous=True out")
    if options.layout.indicators:
        raise ValueError("xla() has no indicators: leave agent_indicator=True out")
    parts = ResultParts(options, port)
    rows = options.batch_size
    shape = (rows,) if options.players == 1 else (rows, options.players)
    handle = jax.numpy.asarray(np.frombuffer(port.handle, np.uint8))
    if callback is None:
        callback = jax.default_backend() != "cpu"
    if callback:
        from atari.integrations.jax.callback import callbacks

        send, recv, step = callbacks(envs, parts)
    else:
        send, recv, step = _foreign_functions(jax, parts)
    return XlaFunctions(handle, recv, *_checked(jax, shape, send, recv, step))


def _foreign_functions(jax: Any, parts: ResultParts) -> tuple[Callable[..., Any], ...]:
    """`send`, `recv` and `step` by calls from XLA to the emulator, without Python."""
    global _registered
    if not _registered:
        for name, target in _emulator.xla_targets().items():
            jax.ffi.register_ffi_target(name, target, platform="cpu")
        _registered = True
    handle_like = jax.ShapeDtypeStruct((8,), np.uint8)
    declared = [jax.ShapeDtypeStruct(shape, dtype) for _, shape, dtype in parts.declared]

    def function(name: str, results: list[Any]) -> Callable[..., Any]:
        return jax.ffi.ffi_call(name, [handle_like, *results], has_side_effect=True, input_output_aliases={0: 0})

    def send(handle: Any, *arguments: Any) -> Any:
        return function("atari_send", [])(handle, *arguments)[0]

    def results_of(name: str) -> Callable[..., Any]:
        def call(handle: Any, *arguments: Any) -> tuple[Any, Any]:
            handle, *arrays = function(name, declared)(handle, *arguments)
            return handle, parts.assemble(arrays)

        return call

    return send, results_of("atari_recv"), results_of("atari_step")


def _checked(
    jax: Any, shape: tuple[int, ...], send: Callable[..., Any], recv: Callable[..., Any], step: Any
) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """`send` and `step` that raise an error for actions of another kind while JAX traces a function."""

    def check(action: Any, env_id: Any) -> list[Any]:
        arrays = [_integers(jax, "actions", action, shape)]
        return arrays if env_id is None else [*arrays, _integers(jax, "env_id", env_id, shape[:1])]

    def checked_send(handle: Any, action: Any, env_id: Any = None) -> Any:
        return send(handle, *check(action, env_id))

    def checked_step(handle: Any, action: Any, env_id: Any = None) -> tuple[Any, Any]:
        arrays = check(action, env_id)
        if env_id is not None:
            return recv(send(handle, *arrays))
        return step(handle, *arrays)

    return checked_send, checked_step


def _integers(jax: Any, name: str, value: Any, shape: tuple[int, ...]) -> Any:
    array = jax.numpy.asarray(value)
    if not jax.numpy.issubdtype(array.dtype, jax.numpy.integer):
        raise TypeError(f"{name} must be integers of shape {shape}, got {array.dtype}")
    if array.shape != shape:
        raise ValueError(f"{name} must have the shape {shape}, got {array.shape}")
    return array
