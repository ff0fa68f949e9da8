"""`Curriculum`: after enough solved episodes in a row, inputs become longer by one character."""

MAX_LENGTH = 30
"""No input is drawn from a greater minimal length."""


class Curriculum:
    """The minimal length of inputs.

    Args:
        length: the initial minimal length.
        window: the number of solved episodes in a row after which it grows.
    """

    def __init__(self, length: int, window: int) -> None:
        self.length = length
        self._window = window
        self._streak = 0

    def record(self, solved: bool) -> None:
        """Count an episode."""
        self._streak = self._streak + 1 if solved else 0
        if self._streak == self._window and self.length < MAX_LENGTH:
            self.length += 1
            self._streak = 0
