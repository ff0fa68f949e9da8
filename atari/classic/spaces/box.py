"""`Box`: arrays between bounds."""

from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces.box import is_float_integer

from atari.classic.spaces.prng import Shared

__all__ = ["Box", "get_inf", "get_precision", "is_float_integer"]


class Box(Shared, gymnasium.spaces.Box):
    """Arrays of a shape, each number between its bounds.

    Args:
        low: the lower bounds, an array, or one number for all.
        high: the upper bounds.
        shape: the shape of the arrays, if the bounds are numbers.
        dtype: the dtype of the arrays; None means float32.
        seed: the seed of `sample`.
    """

    def __init__(self, low: Any, high: Any, shape: Any = None, dtype: Any = None, seed: Any = None) -> None:
        dtype = np.dtype(np.float32 if dtype is None else dtype)
        low, high = (_bound(bound, dtype) for bound in (low, high))
        super().__init__(low, high, shape, dtype, seed)

    def contains(self, x: Any) -> bool:
        """Whether `x` has the shape and lies within the bounds; its dtype does not matter."""
        array = np.asarray(x)
        return array.shape == self.shape and bool(np.all(array >= self.low) and np.all(array <= self.high))

    def __repr__(self) -> str:
        return f"Box{self.shape}"


def _bound(bound: Any, dtype: np.dtype[Any]) -> Any:
    """Bounds of the dtype of the box: scripts give float64, and Gymnasium would warn of the rounding."""
    return np.asarray(bound, dtype) if np.ndim(bound) else bound


def get_inf(dtype: Any, sign: Literal["+", "-"]) -> Any:
    """A number of a dtype that stands for infinity: of integers, the last but two.

    Raises:
        ValueError: the dtype has neither floats nor integers with a sign, or `sign` is neither "+" nor "-".
    """
    kind = np.dtype(dtype).kind
    if kind not in "fi" or sign not in ("+", "-"):
        raise ValueError(
            f"infinity has the dtype of floats or of integers, and the sign '+' or '-', got {dtype} and {sign}"
        )
    if kind == "f":
        return np.inf if sign == "+" else -np.inf
    return np.iinfo(dtype).max - 2 if sign == "+" else np.iinfo(dtype).min + 2


def get_precision(dtype: Any) -> Any:
    """The number of decimal digits of a dtype of floats; infinity for integers."""
    return np.finfo(dtype).precision if np.issubdtype(dtype, np.floating) else np.inf
