"""`Discrete`: one of n integers."""

import operator
from typing import Any

import gymnasium

from atari.classic.spaces.prng import Shared


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
