"""`Discrete`: one of n integers."""

import operator
from typing import Any

import gymnasium

from atari.classic.spaces.prng import Shared


class Discrete(Shared, gymnasium.spaces.Discrete):
    """The integers 0 to n - 1."""

    def __init__(self, n: int) -> None:
        super().__init__(n)
        self._size = int(n)

    def contains(self, x: Any) -> bool:
        """Whether `x` is an integer of any type within 0..n-1."""
        try:
            return 0 <= operator.index(x) < self._size  # faster than Gymnasium's check; it runs at every step
        except TypeError:
            return False

    def __repr__(self) -> str:
        return f"Discrete({self.n})"
