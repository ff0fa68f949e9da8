"""`xla`: functions of an `EnvPool` for functions that JAX compiles."""

from collections.abc import Callable
from typing import Any


def xla(
    functions: tuple[Any, Callable[..., Any], Callable[..., Any], Callable[..., Any]], convert: Callable[[Any], Any]
) -> tuple[Any, Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """Make EnvPool's `(handle, recv, send, step)` from the functions of `atari.integrations.jax.xla`.

    Args:
        functions: the functions of the vector environment.
        convert: converts the vector environment's results to EnvPool's; compiled functions may keep it.
    """
    handle, vector_recv, send, vector_step = functions

    def recv(handle: Any) -> tuple[Any, Any]:
        handle, results = vector_recv(handle)
        return handle, convert(results)

    def step(handle: Any, action: Any, env_id: Any = None) -> tuple[Any, Any]:
        handle, results = vector_step(handle, action, env_id)
        return handle, convert(results)

    return handle, recv, send, step
