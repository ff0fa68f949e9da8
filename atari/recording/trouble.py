"""`Troubled`: keeps the error of a file that could not be written until someone asks.

Files are written in the middle of a step, where an error would leave the environment between two states. So the
recording ends there, the game goes on, and the error is raised by the next call before it does anything.
"""


class Troubled:
    """What writes files during steps."""

    _trouble: OSError | None = None

    def raise_trouble(self) -> None:
        """Tell why the recording has ended, if that was because it could not be written; once.

        Raises:
            OSError: it could not.
        """
        trouble, self._trouble = self._trouble, None
        if trouble is not None:
            raise trouble
