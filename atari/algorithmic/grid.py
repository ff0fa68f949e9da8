"""`GridEnv`: the input is a grid of digits, and the read head moves left, right, up and down."""

import string
from abc import abstractmethod
from typing import Literal

from atari.algorithmic.environment import AlgorithmicEnv, Rows


class GridEnv(AlgorithmicEnv):
    """A task on a grid of so many rows; the head starts on the upper left digit. See `AlgorithmicEnv` for the rest.

    Raises:
        ValueError: there is no row, or another option is out of range.
    """

    moves = ("left", "right", "up", "down")
    alphabet = string.digits

    def __init__(
        self, rows: int, base: int, min_length: int = 2, render_mode: Literal["human", "ansi"] | None = None
    ) -> None:
        if rows < 1:
            raise ValueError(f"rows is at least 1, got {rows!r}")
        self.height = rows
        super().__init__(base, min_length, render_mode)

    def draw(self, length: int) -> Rows:
        """Rows of independent digits."""
        rows: Rows = self.np_random.integers(self.base, size=(self.height, length)).tolist()
        return rows

    def solve(self, rows: Rows) -> list[int]:
        """What must be written for the columns of the grid."""
        return self.solve_columns(list(zip(*rows, strict=True)))

    @abstractmethod
    def solve_columns(self, columns: list[tuple[int, ...]]) -> list[int]:
        """What must be written for a grid, given by its columns from left to right."""
