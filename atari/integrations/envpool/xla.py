"""`EnvPool` inside functions that JAX compiles: the functions of its vector environment, with EnvPool's results."""

from collections.abc import Callable
from typing import Any


def xla(
    functions: tuple[Any, Callable[..., Any], Callable[..., Any], Callable[..., Any]], shown: Callable[[Any], Any]
) -> tuple[Any, Callable[..., Any], Callable[..., Any], Callable[..., Any]]:
    """`(handle, recv, send, step)` from those of `AtariVectorEnv.xla`.

    Args:
        functions: of the vector environment.
        shown: makes EnvPool's results of the vector environment's; compiled functions may keep it.
    """
    handle, vector_recv, send, vector_step = functions

    def recv(handle: Any) -> tuple[Any, Any]:
        handle, results = vector_recv(handle)
        return handle, shown(results)

    def step(handle: Any, action: Any, env_id: Any = None) -> tuple[Any, Any]:
        handle, results = vector_step(handle, action, env_id)
        return handle, shown(results)

    return handle, recv, send, step
