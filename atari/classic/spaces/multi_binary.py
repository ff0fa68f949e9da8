"""`MultiBinary`: n bits."""

from typing import Any

import gymnasium

from atari.classic.spaces.prng import Shared


class MultiBinary(Shared, gymnasium.spaces.MultiBinary):
    """Arrays of n numbers, each 0 or 1; `n` may be a shape."""

    def __init__(self, n: Any, seed: Any = None) -> None:
        super().__init__(n, seed)

    def __repr__(self) -> str:
        return f"MultiBinary({self.n})"
