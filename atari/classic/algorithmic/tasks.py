"""The inputs, a tape or a grid, and the five tasks: the target of each, and how its inputs are drawn."""

import string
from abc import abstractmethod
from typing import Literal

from atari.base.validation import check_integer
from atari.classic.algorithmic.environment import AlgorithmicEnv, Rows

RenderMode = Literal["human", "ansi"] | None


class TapeEnv(AlgorithmicEnv):
    """A task on a tape; the head starts on its first letter. See `AlgorithmicEnv` for arguments and rules.

    Example:
        >>> from atari.classic.algorithmic import CopyEnv, TapeEnv
        >>> issubclass(CopyEnv, TapeEnv), CopyEnv.moves
        (True, ('left', 'right'))
    """

    moves = ("left", "right")
    alphabet = string.ascii_uppercase

    def draw(self, length: int) -> Rows:
        """One row of independent letters."""
        return [self.np_random.integers(self.base, size=length).tolist()]

    def solve(self, rows: Rows) -> list[int]:
        """The letters that must be written for the single row."""
        return self.solve_tape(rows[0])

    @abstractmethod
    def solve_tape(self, tape: list[int]) -> list[int]:
        """The letters that must be written for a tape."""


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

    def __init__(self, rows: int, base: int, min_length: int = 2, render_mode: RenderMode = None) -> None:
        self.height = check_integer("rows", rows, 1, 100)
        super().__init__(base, min_length, render_mode)

    def draw(self, length: int) -> Rows:
        """Rows of independent digits."""
        return self.np_random.integers(self.base, size=(self.height, length)).tolist()

    def solve(self, rows: Rows) -> list[int]:
        """The digits that must be written for the rows of a grid."""
        return self.solve_columns(list(zip(*rows, strict=True)))

    @abstractmethod
    def solve_columns(self, columns: list[tuple[int, ...]]) -> list[int]:
        """The digits that must be written for a grid, given by its columns from left to right."""


class CopyEnv(TapeEnv):
    """Write the letters of the tape.

    Example:
        >>> from atari.classic.algorithmic import CopyEnv
        >>> env = CopyEnv()
        >>> observation, info = env.reset(seed=0)
        >>> env.step((1, 1, observation))[1]
        1.0
    """

    def solve_tape(self, tape: list[int]) -> list[int]:
        """The tape itself."""
        return tape


class DuplicatedInputEnv(TapeEnv):
    """Each letter occurs `duplication` times in a row, 1 to 100; write it once.

    Example:
        >>> from atari.classic.algorithmic import DuplicatedInputEnv
        >>> env = DuplicatedInputEnv(duplication=2)
        >>> observation, info = env.reset(seed=0)
        >>> env.step((1, 1, observation))[1]
        1.0
    """

    def __init__(
        self, duplication: int = 2, base: int = 5, min_length: int = 2, render_mode: RenderMode = None
    ) -> None:
        self.duplication = check_integer("duplication", duplication, 1, 100)
        super().__init__(base, min_length, render_mode)

    def draw(self, length: int) -> Rows:
        """Letters, each repeated: the most that fit, but at least one."""
        letters = super().draw(max(length // self.duplication, 1))[0]
        return [[letter for letter in letters for _ in range(self.duplication)]]

    def solve_tape(self, tape: list[int]) -> list[int]:
        """The first of each repetition."""
        return tape[:: self.duplication]


class RepeatCopyEnv(TapeEnv):
    """Write the tape forwards, then backwards, then forwards again.

    Example:
        >>> from atari.classic.algorithmic import RepeatCopyEnv
        >>> env = RepeatCopyEnv()
        >>> observation, info = env.reset(seed=0)
        >>> env.step((1, 1, observation))[1]
        1.0
    """

    window = 50

    def solve_tape(self, tape: list[int]) -> list[int]:
        """Forwards, backwards, forwards."""
        return tape + tape[::-1] + tape


class ReverseEnv(TapeEnv):
    """Write the tape backwards.

    Example:
        >>> from atari.classic.algorithmic import ReverseEnv
        >>> env = ReverseEnv()
        >>> observation, info = env.reset(seed=0)
        >>> env.step((1, 0, 0))[1]
        0.0
    """

    window = 50

    def __init__(self, base: int = 2, min_length: int = 1, render_mode: RenderMode = None) -> None:
        super().__init__(base, min_length, render_mode)

    def solve_tape(self, tape: list[int]) -> list[int]:
        """Backwards."""
        return tape[::-1]


class ReversedAdditionEnv(GridEnv):
    """Add the numbers in the rows of the grid and write the sum, all with their lowest digits first.

    Args:
        rows: the number of numbers, 1 to 100.
        base: the base of the numbers, 1 to 10.
        min_length: the number of their digits at first, 1 to 30.
        steps_per_column: time limit, 1 to 100, to which 4 steps are added. Gym's is 2, too little to read three rows
            of more than four digits: no agent solves `ReversedAddition3-v0` as published, and 3 makes it solvable.
        render_mode: "ansi" or "human".

    Example:
        >>> from atari.classic.algorithmic import ReversedAdditionEnv
        >>> env = ReversedAdditionEnv(rows=2)
        >>> observation, info = env.reset(seed=0)
        >>> env.step((3, 0, 0))[1]
        0.0
    """

    def __init__(
        self,
        rows: int = 2,
        base: int = 3,
        min_length: int = 2,
        steps_per_column: int = 2,
        render_mode: RenderMode = None,
    ) -> None:
        self.steps_per_column = check_integer("steps_per_column", steps_per_column, 1, 100)
        super().__init__(rows, base, min_length, render_mode)

    @property
    def time_limit(self) -> int:
        """The number of steps allowed for the current input."""
        return self.steps_per_column * len(self.rows[0]) + 4

    def solve_columns(self, columns: list[tuple[int, ...]]) -> list[int]:
        """The digits of the sum, which may have more digits than the grid has columns."""
        digits: list[int] = []
        carry = 0
        for column in columns:
            carry, digit = divmod(sum(column) + carry, self.base)
            digits.append(digit)
        while carry:
            carry, digit = divmod(carry, self.base)
            digits.append(digit)
        return digits
