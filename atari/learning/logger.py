"""`Logger`: a program of the user's that gets each row of a training's log, for a logging service."""

import warnings
from collections.abc import Callable, Mapping
from typing import Any

from atari.learning.run_folder import RunFolder


class Logger:
    """Calls a user's object with each row. An error of the object is a warning: the training goes on.

    Args:
        make: a class or function that makes the object from the run folder. The object is called with each row. Its
            method `close()`, if it has one, is called at the end.
        run: the folder.

    Raises:
        RuntimeError: the object cannot be made.
        TypeError: the object cannot be called.
    """

    def __init__(self, make: Callable[[RunFolder], Any], run: RunFolder) -> None:
        self._name = f"logger {getattr(make, '__name__', make)}"
        try:
            self._log = make(run)
        except Exception as error:
            raise RuntimeError(f"{self._name} cannot be made: {type(error).__name__}: {error}") from error
        if not callable(self._log):
            raise TypeError(
                f"{self._name} must make an object that is called with each row, from the RunFolder; got "
                f"{self._log!r:.60}"
            )
        self._warned = False

    def log(self, row: Mapping[str, float]) -> None:
        """Pass a row on."""
        self._call(lambda: self._log(dict(row)), f"at step {row['step']:,}")

    def close(self) -> None:
        """End the object's work."""
        self._call(getattr(self._log, "close", lambda: None), "at its end")

    def _call(self, function: Callable[[], Any], when: str) -> None:
        try:
            function()
        except Exception as error:
            if not self._warned:
                text = f"{self._name} failed {when}, and the training goes on: {type(error).__name__}: {error}"
                warnings.warn(f"{text}; its later errors are not shown", RuntimeWarning, stacklevel=4)
            self._warned = True
