"""`MultiDiscrete`: several integers, each with its own range."""

from typing import Any

import gymnasium
import numpy as np

from atari.classic.spaces.prng import Shared


class MultiDiscrete(Shared, gymnasium.spaces.MultiDiscrete):
    """Arrays of integers, number i within 0 to nvec[i] - 1."""

    def __init__(self, nvec: Any, dtype: Any = np.int64, seed: Any = None) -> None:
        super().__init__(nvec, dtype, seed)

    def __repr__(self) -> str:
        return f"MultiDiscrete({self.nvec})"
