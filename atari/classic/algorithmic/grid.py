"""`GridEnv`: the input is a grid of digits, and the read head moves left, right, up and down."""

import string
from abc import abstractmethod
from typing import Literal

from atari.classic.algorithmic.checks import check_integer
from atari.classic.algorithmic.environment import AlgorithmicEnv, Rows


class GridEnv(AlgorithmicEnv):
    """A task on a grid of `rows` rows; the head starts on the upper left digit. See `AlgorithmicEnv` for the rest.

    Raises:
        TypeError, ValueError: an option is not an integer, or out of range; a grid has 1 to 100 rows.

    Example:
        >>> from atari.classic.algorithmic import GridEnv, ReversedAdditionEnv
        >>> issubclass(ReversedAdditionEnv, GridEnv), GridEnv.moves
        (True, ('left', 'right', 'up', 'down'))
    """

    moves = ("left", "right", "up", "down")
    alphabet = string.digits

    def __init__(
        self, rows: int, base: int, min_length: int = 2, render_mode: Literal["human", "ansi"] | None = None
    ) -> None:
        self.height = check_integer("rows", rows, 1, 100)
        super().__init__(base, min_length, render_mode)

    def draw(self, length: int) -> Rows:
        """Rows of independent digits."""
        rows: Rows = self.np_random.integers(self.base, size=(self.height, length)).tolist()
        return rows

    def solve(self, rows: Rows) -> list[int]:
        """The digits that must be written for the rows of a grid."""
        return self.solve_columns(list(zip(*rows, strict=True)))

    @abstractmethod
    def solve_columns(self, columns: list[tuple[int, ...]]) -> list[int]:
        """The digits that must be written for a grid, given by its columns from left to right."""
