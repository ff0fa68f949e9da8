"""`send`, `recv` and `step` by callbacks, which run in Python on the host: for devices other than CPUs.

Each callback takes the handle and returns it, so calls run in the order of the chain of handles. If JAX's device has
page-locked memory, observations are written there, and a GPU copies them by itself.
"""

import ctypes
import weakref
from collections.abc import Callable
from itertools import cycle
from typing import Any

import jax
import jax.numpy
import numpy as np
from jax.experimental import io_callback

from atari.integrations.jax.results import ResultParts


def callbacks(envs: Any, parts: ResultParts) -> tuple[Callable[..., Any], ...]:
    """`send(handle, action, env_id=None)`, `recv(handle)` and `step(handle, action)`.

    Args:
        envs: the vector environment; compiled functions do not keep it alive.
        parts: the arrays that `recv` returns.
    """
    # JAX may keep compiled functions, and the objects that they refer to, until the process ends.
    proxy = weakref.proxy(envs)
    declared = [jax.ShapeDtypeStruct(shape, dtype) for _, shape, dtype in parts.declared]
    results = jax.eval_shape(parts.assemble, declared)
    handle_like = jax.ShapeDtypeStruct((8,), np.uint8)
    # Two arrays in turn: the device may copy from one while the environments write to the other.
    arrays = pinned_arrays(results[0]) if parts.as_written else None
    outs = cycle(arrays or [None])

    def send_on_host(handle: Any, action: Any, *env_id: Any) -> Any:
        if env_id:
            proxy.send(np.asarray(action), env_id=np.asarray(env_id[0]))
        else:
            proxy.send(np.asarray(action), out=next(outs))
        return handle

    def recv_on_host(handle: Any) -> Any:
        return handle, tuple(filled(part, wanted) for part, wanted in zip(proxy.recv(), results, strict=True))

    def step_on_host(handle: Any, action: Any) -> Any:
        return recv_on_host(send_on_host(handle, action))

    def send(handle: Any, *arguments: Any) -> Any:
        return io_callback(send_on_host, handle_like, handle, *apart(handle, arguments))

    def recv(handle: Any) -> tuple[Any, Any]:
        handle, values = io_callback(recv_on_host, (handle_like, results), handle)
        return handle, apart(handle, values)

    def step(handle: Any, action: Any) -> tuple[Any, Any]:
        handle, values = io_callback(step_on_host, (handle_like, results), handle, apart(handle, action))
        return handle, apart(handle, values)

    return send, recv, step


def apart(handle: Any, values: Any) -> Any:
    """Equal arrays that XLA does not fuse with a slice of another array, because they depend on a condition.

    On GPUs, the compiler of JAX 0.11.2 fuses callbacks with slices and keeps a second call of each: without this, a
    scan plays every step twice, and with JAX's ordered callbacks the process ends.

    Args:
        handle: the handle, which has a byte that is not zero: the compiler does not know that.
        values: an array, or a tree of arrays.
    """
    valid = handle.any()
    return jax.tree_util.tree_map(lambda array: jax.numpy.where(valid, array, jax.numpy.zeros_like(array)), values)


def filled(value: Any, wanted: Any) -> Any:
    """An array, or dict of arrays, in the declared form: absent arrays are zero, undeclared arrays are left out."""
    if isinstance(wanted, dict):
        return {name: filled((value or {}).get(name), part) for name, part in wanted.items()}
    return np.zeros(wanted.shape, wanted.dtype) if value is None else np.asarray(value).astype(wanted.dtype, copy=False)


def pinned_arrays(like: Any) -> list[Any] | None:
    """Two NumPy arrays in page-locked memory; None if the default device has none, or `like` is not uint8.

    Args:
        like: an object with the `shape` and `dtype` of the arrays.
    """
    device = jax.devices()[0]
    kinds = {memory.kind for memory in device.addressable_memories()}
    if "pinned_host" not in kinds or like.dtype != np.uint8:
        return None
    memory = jax.sharding.SingleDeviceSharding(device, memory_kind="pinned_host")
    return [_view(jax.device_put(np.zeros(like.shape, np.uint8), memory)) for _ in range(2)]


def _view(array: Any) -> Any:
    """The memory of a JAX array, which nothing else uses, as a writable NumPy array that keeps the JAX array alive."""
    memory: Any = (ctypes.c_uint8 * int(np.prod(array.shape))).from_address(array.unsafe_buffer_pointer())
    memory.kept = array
    return np.frombuffer(memory, np.uint8).reshape(array.shape)
