"""The five tasks: what is to be written, and how the input is drawn where it is not just any characters."""

from typing import Literal

from atari.algorithmic.environment import Rows
from atari.algorithmic.grid import GridEnv
from atari.algorithmic.tape import TapeEnv
from atari.cores.options import check_integer

RenderMode = Literal["human", "ansi"] | None


class CopyEnv(TapeEnv):
    """Write what is on the tape."""

    def __init__(self, base: int = 5, min_length: int = 2, render_mode: RenderMode = None) -> None:
        super().__init__(base, min_length, render_mode)

    def solve_tape(self, tape: list[int]) -> list[int]:
        """The same."""
        return tape


class DuplicatedInputEnv(TapeEnv):
    """Each letter is there `duplication` times in a row, 1 to 100; write it once."""

    def __init__(
        self, duplication: int = 2, base: int = 5, min_length: int = 2, render_mode: RenderMode = None
    ) -> None:
        self.duplication = check_integer("duplication", duplication, 1, 100)
        super().__init__(base, min_length, render_mode)

    def draw(self, length: int) -> Rows:
        """Letters, each repeated; as many as fit, and one at least."""
        letters = super().draw(max(length // self.duplication, 1))[0]
        return [[letter for letter in letters for _ in range(self.duplication)]]

    def solve_tape(self, tape: list[int]) -> list[int]:
        """The first of each."""
        return tape[:: self.duplication]


class RepeatCopyEnv(TapeEnv):
    """Write what is on the tape, then the same from its end, then again from its start."""

    window = 50

    def __init__(self, base: int = 5, min_length: int = 2, render_mode: RenderMode = None) -> None:
        super().__init__(base, min_length, render_mode)

    def solve_tape(self, tape: list[int]) -> list[int]:
        """There, back, and there."""
        return tape + tape[::-1] + tape


class ReverseEnv(TapeEnv):
    """Write what is on the tape, from its end."""

    window = 50

    def __init__(self, base: int = 2, min_length: int = 1, render_mode: RenderMode = None) -> None:
        super().__init__(base, min_length, render_mode)

    def solve_tape(self, tape: list[int]) -> list[int]:
        """From the end."""
        return tape[::-1]


class ReversedAdditionEnv(GridEnv):
    """Add the numbers in the rows of the grid, whose lowest digits are on the left, and write the sum that way, too.

    Args:
        rows: how many numbers, 1 to 100.
        base: of the numbers, 1 to 10.
        min_length: how many digits they have at first, 1 to 30.
        steps_per_column: time limit, 1 to 100, to which 4 steps are added. Gym's is 2, too little to read three rows
            of more than four digits: no agent solves `ReversedAddition3-v0` as published, and 3 makes it solvable.
        render_mode: "ansi" or "human".
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
        """How many steps there are for the current input."""
        return self.steps_per_column * len(self.rows[0]) + 4

    def solve_columns(self, columns: list[tuple[int, ...]]) -> list[int]:
        """The digits of the sum, which may be more than there are columns."""
        digits: list[int] = []
        carry = 0
        for column in columns:
            carry, digit = divmod(sum(column) + carry, self.base)
            digits.append(digit)
        while carry:
            carry, digit = divmod(carry, self.base)
            digits.append(digit)
        return digits
