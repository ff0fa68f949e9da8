"""`ArraySpec`: the shapes, dtypes and bounds of the arrays that an `EnvPool` receives and returns."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

_FLOAT32 = (float(np.finfo(np.float32).min), float(np.finfo(np.float32).max))
_INT32 = (-(2**31), 2**31 - 1)


@dataclass(frozen=True)
class ArraySpec:
    """A row of an array; -1 in its shape stands for the players, who are one here.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> envpool.make_spec("Pong-v5").state_array_spec["obs"].shape
        [4, 84, 84]
    """

    dtype: npt.DTypeLike
    shape: list[int]
    bounds: tuple[Any, Any]
    element_wise_bounds: tuple[Any, Any] = ((), ())
    is_discrete: bool = False

    @property
    def minimum(self) -> Any:
        """The least value, or the array of them."""
        return np.array(self.element_wise_bounds[0]) if self.element_wise_bounds[0] else self.bounds[0]

    @property
    def maximum(self) -> Any:
        """The greatest value, or the array of them."""
        return np.array(self.element_wise_bounds[1]) if self.element_wise_bounds[1] else self.bounds[1]

    def __repr__(self) -> str:
        return f"ArraySpec(shape={self.shape}, dtype={self.dtype}, minimum={self.minimum}, maximum={self.maximum})"


def _spec(dtype: npt.DTypeLike, shape: list[int], bounds: tuple[Any, Any]) -> ArraySpec:
    return ArraySpec(np.dtype(dtype), shape, bounds)


def state_arrays(shape: tuple[int, ...]) -> dict[str, ArraySpec]:
    """The arrays that `recv` returns, with observations of this shape, by EnvPool's names."""
    return {
        "info:env_id": _spec(np.int32, [], _INT32),
        "info:players.env_id": _spec(np.int32, [-1], _INT32),
        "elapsed_step": _spec(np.int32, [], _INT32),
        "done": _spec(np.bool_, [], (False, True)),
        "reward": _spec(np.float32, [-1], _FLOAT32),
        "discount": _spec(np.float32, [-1], (0.0, 1.0)),
        "step_type": _spec(np.int32, [], _INT32),
        "trunc": _spec(np.bool_, [], (False, True)),
        "obs": _spec(np.uint8, [*shape], (0, 255)),
        "info:lives": _spec(np.int32, [-1], _INT32),
        "info:reward": _spec(np.float32, [-1], _FLOAT32),
        "info:terminated": _spec(np.int32, [-1], (0, 1)),
        "info:ram": _spec(np.uint8, [128], (0, 255)),
    }


def action_arrays(actions: int) -> dict[str, ArraySpec]:
    """The arrays that `send` takes, for this number of actions, by EnvPool's names."""
    return {
        "env_id": _spec(np.int32, [], _INT32),
        "players.env_id": _spec(np.int32, [-1], _INT32),
        "action": _spec(np.int32, [-1], (0, actions - 1)),
    }
