"""`TapeEnv`: the input is a tape of letters, and the read head moves left and right."""

import string
from abc import abstractmethod

from atari.classic.algorithmic.environment import AlgorithmicEnv, Rows


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
