"""`DeferredErrorMixin`: keeps the error of a failed write until the next call of the environment, which raises it.

Files are written in the middle of a step. An error raised there would leave the environment between two states. So the
recording ends, the step completes, and the next call raises the error before it changes anything.
"""


class DeferredErrorMixin:
    """The base of recorders that write files during steps. It owns at most one deferred error."""

    _deferred_error: OSError | None = None

    def raise_deferred_error(self) -> None:
        """Raise the deferred error and drop it; without one, do nothing.

        Raises:
            OSError: the file could not be written.
        """
        error, self._deferred_error = self._deferred_error, None
        if error is not None:
            raise error
