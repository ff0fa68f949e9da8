"""`MultiDiscrete`: several integers, each with its own range."""

from typing import Any

import gymnasium

from atari.classic.spaces.prng import Shared


class MultiDiscrete(Shared, gymnasium.spaces.MultiDiscrete):
    """Arrays of integers, number i within 0 to nvec[i] - 1."""

    def __init__(self, nvec: Any) -> None:
        super().__init__(nvec)

    def __repr__(self) -> str:
        return f"MultiDiscrete({self.nvec})"
