"""`EnvPool` inside functions that JAX compiles: ordered callbacks, which run on the host."""

import weakref
from typing import Any

import gymnasium
import numpy as np


def xla(envs: Any) -> tuple[Any, Any, Any, Any]:
    """`(handle, recv, send, step)` of an `EnvPool`.

    `handle` is a uint8 array (8,). `recv(handle)` and `step(handle, action, env_id=None)` return a handle and what the
    methods of these names return; `send(handle, action, env_id=None)` returns a handle. `env_id` must have as many rows
    as a batch. Reset the environments, or call `async_reset`, before the first step. The environments are played once
    for each time that a function runs, in the order of the calls. They must exist as long as compiled functions run.

    Raises:
        gymnasium.error.DependencyNotInstalled: JAX is not installed.
    """
    try:
        import jax
        from jax.experimental import io_callback
    except ImportError:
        raise gymnasium.error.DependencyNotInstalled("xla() needs JAX: pip install jax") from None

    # JAX may keep compiled functions, and what they refer to, until the process ends.
    proxy = weakref.proxy(envs)

    def send_on_host(action: Any, *env_id: Any) -> None:
        proxy.send(np.asarray(action), *map(np.asarray, env_id))

    def recv_on_host() -> Any:
        return proxy.recv()

    def send(handle: Any, action: Any, env_id: Any = None) -> Any:
        arguments = (action,) if env_id is None else (action, env_id)
        io_callback(send_on_host, None, *arguments, ordered=True)
        return handle

    def recv(handle: Any) -> tuple[Any, Any]:
        shapes = jax.tree_util.tree_map(lambda array: jax.ShapeDtypeStruct(array.shape, array.dtype), _example(envs))
        return handle, io_callback(recv_on_host, shapes, ordered=True)

    def step(handle: Any, action: Any, env_id: Any = None) -> tuple[Any, Any]:
        return recv(send(handle, action, env_id))

    return jax.numpy.zeros(8, np.uint8), recv, send, step


def _example(envs: Any) -> Any:
    """Results of a step, of which only shapes and dtypes count."""
    rows = envs.vector.batch_size
    shape = envs.spec.gymnasium_observation_space.shape
    numbers, flags = np.zeros(rows, np.int32), np.zeros(rows, np.bool_)
    info = {
        "env_id": numbers,
        "players": {"env_id": numbers},
        "lives": numbers,
        "reward": np.zeros(rows, np.float32),
        "terminated": numbers,
        "ram": np.zeros((rows, 128), np.uint8),
        "elapsed_step": numbers,
        "TimeLimit.truncated": flags,
    }
    ends = (flags,) if envs.returns_done else (flags, flags)
    return np.zeros((rows, *shape), np.uint8), np.zeros(rows, np.float32), *ends, info
