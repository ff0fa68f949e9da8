"""Gym's spaces, which print as `Discrete(2)` or `Box(4,)`.

They are subclasses of Gymnasium's, with Gym's constructors and texts, so that Gymnasium's wrappers and other libraries
accept them.
"""

import operator
from types import ModuleType
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import GraphInstance, Sequence, Space, Text
from gymnasium.spaces.utils import flatdim, flatten, unflatten
from gymnasium.vector.utils import batch_space

from atari.classic.spaces import prng
from atari.classic.spaces.prng import Shared, seed

__all__ = [
    "Box",
    "Dict",
    "Discrete",
    "Graph",
    "GraphInstance",
    "MultiBinary",
    "MultiDiscrete",
    "Sequence",
    "Space",
    "Text",
    "Tuple",
    "dict_space",
    "flatdim",
    "flatten",
    "flatten_space",
    "from_gymnasium",
    "prng",
    "seed",
    "tuple_space",
    "unflatten",
    "utils",
]

dict_space: ModuleType
tuple_space: ModuleType
utils: ModuleType
"""Modules of Gym, of the table in `gym_modules`."""


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


class Dict(gymnasium.spaces.Dict):
    """Dictionaries with an element of each space; the spaces are given as a dictionary, as pairs, or by keyword."""

    def __init__(self, spaces: Any = None, seed: Any = None, **spaces_kwargs: gymnasium.Space[Any]) -> None:
        super().__init__(spaces_kwargs if spaces is None else spaces, seed)

    def __repr__(self) -> str:
        return f"Dict({', '.join(f'{name}:{space}' for name, space in self.spaces.items())})"


class Discrete(Shared, gymnasium.spaces.Discrete):
    """The integers 0 to n - 1, or from `start` on."""

    def __init__(self, n: int, seed: Any = None, start: int = 0) -> None:
        super().__init__(n, seed, start)
        self._range = range(int(start), int(start) + int(n))

    def contains(self, x: Any) -> bool:
        """Whether `x` is an integer of any type among them."""
        try:
            return operator.index(x) in self._range  # faster than Gymnasium's check; it runs at every step
        except TypeError:
            return False

    def __repr__(self) -> str:
        return f"Discrete({self.n}, start={self.start})" if self.start else f"Discrete({self.n})"


class Graph(gymnasium.spaces.Graph):
    """Graphs, as tuples `GraphInstance` of nodes, edges and the two nodes of each edge."""

    def sample(  # type: ignore[override]
        self, mask: Any = None, num_nodes: int = 10, num_edges: int | None = None, probability: Any = None
    ) -> GraphInstance:
        """Draw a graph.

        Args:
            mask: masks of the node space and the edge space, for spaces that have masks.
            num_nodes: the number of nodes, 1 or more.
            num_edges: the number of edges; None draws it.
            probability: probabilities of the elements of both spaces, instead of masks.
        """
        if mask is not None or probability is not None:
            options = {} if probability is None else {"probability": probability}  # before 1.0 there were none
            return super().sample(mask=mask, num_nodes=num_nodes, num_edges=num_edges, **options)
        if num_nodes < 1:
            raise ValueError(f"a graph has 1 node or more, got num_nodes={num_nodes}")
        most = num_nodes * (num_nodes - 1)
        count = num_edges if num_edges is not None else int(self.np_random.integers(most)) if most else 0
        nodes: Any = self._generate_sample_space(self.node_space, num_nodes)
        edges = self._generate_sample_space(self.edge_space, count)
        return GraphInstance(
            nodes.sample(),
            None if edges is None else edges.sample(),
            None if edges is None else self.np_random.integers(0, num_nodes, (count, 2), np.int32),
        )

    def _generate_sample_space(self, base_space: Space[Any] | None, num: int) -> Space[Any] | None:
        """The space of `num` elements; None for none."""
        if base_space is None or num == 0:
            return None
        space = batch_space(base_space, num)
        space.seed(int(self.np_random.integers(2**31)))  # else all graphs had the same nodes
        return space


class MultiBinary(Shared, gymnasium.spaces.MultiBinary):
    """Arrays of n numbers, each 0 or 1; `n` may be a shape."""

    def __repr__(self) -> str:
        return f"MultiBinary({self.n})"


class MultiDiscrete(Shared, gymnasium.spaces.MultiDiscrete):
    """Arrays of integers, number i within 0 to nvec[i] - 1."""

    def __repr__(self) -> str:
        return f"MultiDiscrete({self.nvec})"


class Tuple(gymnasium.spaces.Tuple):  # type: ignore[type-arg]
    """Tuples of an element of each space."""

    def __repr__(self) -> str:
        return f"Tuple({', '.join(map(repr, self.spaces))})"


def from_gymnasium(space: Space[Any]) -> Space[Any]:
    """The classic space of the same elements; a space that Gym did not have is returned unchanged."""
    if isinstance(space, gymnasium.spaces.Box):
        return Box(space.low, space.high, dtype=space.dtype)
    if isinstance(space, gymnasium.spaces.Discrete) and space.start == 0:
        return Discrete(int(space.n))
    if isinstance(space, gymnasium.spaces.MultiDiscrete) and not space.start.any():
        return MultiDiscrete(space.nvec)
    if isinstance(space, gymnasium.spaces.MultiBinary):
        return MultiBinary(space.n)
    if isinstance(space, gymnasium.spaces.Tuple):
        return Tuple(from_gymnasium(part) for part in space.spaces)
    if isinstance(space, gymnasium.spaces.Dict):
        return Dict({name: from_gymnasium(part) for name, part in space.spaces.items()})
    return space


def flatten_space(space: Space[Any]) -> Space[Any]:
    """The `Box` of the flat elements of a space.

    Example:
        >>> from atari.classic import spaces
        >>> spaces.flatten_space(spaces.Dict(place=spaces.Discrete(4), speed=spaces.Box(-1, 1, (2,))))
        Box(6,)
    """
    return from_gymnasium(gymnasium.spaces.flatten_space(space))
