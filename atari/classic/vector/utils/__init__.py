"""Batches of elements of spaces, by Gymnasium's functions.

The order of arguments changed between Gym 0.21 and 0.26: the space came last, and then first. Both are accepted.
"""

import multiprocessing
from collections.abc import Iterable
from typing import Any

from gymnasium.vector import utils as _modern
from gymnasium.vector.utils import CloudpickleWrapper, clear_mpi_env_vars, create_empty_array, iterate

from atari.classic.spaces import (
    Box,
    Dict,
    Discrete,
    MultiBinary,
    MultiDiscrete,
    Space,
    Tuple,
    from_gymnasium,
)

BaseGymSpaces = (Box, Discrete, MultiDiscrete, MultiBinary)
_BaseGymSpaces = BaseGymSpaces
STANDARD_SPACES = (*BaseGymSpaces, Tuple, Dict)

__all__ = [
    "STANDARD_SPACES",
    "BaseGymSpaces",
    "CloudpickleWrapper",
    "batch_space",
    "clear_mpi_env_vars",
    "concatenate",
    "create_empty_array",
    "create_shared_memory",
    "iterate",
    "read_from_shared_memory",
    "write_several_to_shared_memory",
    "write_to_shared_memory",
]


def batch_space(space: Space[Any], n: int = 1) -> Space[Any]:
    """The space of batches of n elements.

    Example:
        >>> from atari.classic import spaces, vector
        >>> vector.utils.batch_space(spaces.Box(0, 1, (4,)), 3)
        Box(3, 4)
    """
    return from_gymnasium(_modern.batch_space(space, n))


def concatenate(items: Iterable[Any], out: Any, space: Space[Any]) -> Any:
    """Write elements of a space into a batch, `out` of `create_empty_array`, and return it.

    Example:
        >>> from atari.classic import spaces
        >>> from atari.classic.vector.utils import concatenate, create_empty_array
        >>> space = spaces.Box(0, 9, (2,))
        >>> concatenate([[1, 2], [3, 4]], create_empty_array(space, 2), space).tolist()
        [[1.0, 2.0], [3.0, 4.0]]
    """
    if isinstance(items, Space):  # (space, items, out), as in 0.26
        items, out, space = out, space, items  # type: ignore[assignment]
    return _modern.concatenate(space, list(items), out)


def create_shared_memory(space: Space[Any], n: int = 1, ctx: Any = multiprocessing) -> Any:
    """Memory for n elements of a space, which processes share."""
    return _modern.create_shared_memory(space, n, ctx)


def read_from_shared_memory(shared_memory: Any, space: Space[Any], n: int = 1) -> Any:
    """A batch in shared memory, without a copy."""
    if isinstance(shared_memory, Space):  # (space, shared_memory), as in 0.26
        shared_memory, space = space, shared_memory
    return _modern.read_from_shared_memory(space, shared_memory, n)


def write_to_shared_memory(index: int, value: Any, shared_memory: Any, space: Space[Any]) -> None:
    """Write an element into shared memory, as number `index` of the batch."""
    given: tuple[Any, ...] = space, index, value, shared_memory
    if isinstance(index, Space):  # in this order already, as in 0.26
        given = index, value, shared_memory, space
    _modern.write_to_shared_memory(*given)


def write_several_to_shared_memory(index: int, values: Any, shared_memory: Any, space: Space[Any]) -> None:
    """Write an element of a Dict or Tuple space, see `write_to_shared_memory`."""
    write_to_shared_memory(index, values, shared_memory, space)
