"""The algorithmic tasks: copy, reverse and add the content of a tape (see `atari.classic.algorithmic`)."""

from atari.classic import algorithmic
from atari.classic.envs.adapted import Adapted

__all__ = ["CopyEnv", "DuplicatedInputEnv", "RepeatCopyEnv", "ReverseEnv", "ReversedAdditionEnv"]


class CopyEnv(Adapted):
    """Write the letters of the tape."""

    original = algorithmic.CopyEnv

    def __init__(self, base: int = 5, chars: bool = True) -> None:
        super().__init__(base=base)  # the task decides whether digits or letters (`chars`) are printed


class DuplicatedInputEnv(Adapted):
    """Each letter occurs `duplication` times in a row; write it once."""

    original = algorithmic.DuplicatedInputEnv

    def __init__(self, duplication: int = 2, base: int = 5) -> None:
        super().__init__(duplication=duplication, base=base)


class RepeatCopyEnv(Adapted):
    """Write the tape forwards, then backwards, then forwards again."""

    original = algorithmic.RepeatCopyEnv

    def __init__(self, base: int = 5) -> None:
        super().__init__(base=base)


class ReverseEnv(Adapted):
    """Write the tape backwards."""

    original = algorithmic.ReverseEnv

    def __init__(self, base: int = 2) -> None:
        super().__init__(base=base)


class ReversedAdditionEnv(Adapted):
    """Add the numbers of `rows` rows, whose least digit comes first."""

    original = algorithmic.ReversedAdditionEnv

    def __init__(self, rows: int = 2, base: int = 3) -> None:
        super().__init__(rows=rows, base=base)
