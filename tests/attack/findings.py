"""What an attacked call may do, and what is a finding."""

from collections.abc import Callable
from typing import Any

from gymnasium import error

ALLOWED = (
    *(TypeError, ValueError, LookupError, RuntimeError, OSError, MemoryError),
    *(
        error.Error,
        error.ResetNeeded,
        error.ClosedEnvironmentError,
        error.AlreadyPendingCallError,
        error.NoAsyncCallError,
    ),
)
"""The exceptions with which a call may refuse its arguments or its moment. Everything else is a finding, and KeyError."""


RAW = "Invoked with types: "
"""A part of the text with which nanobind refuses arguments. Only calls of the private module `atari._emulator` may
raise it, and ale-py's own methods, which `AleCore` hands out."""


def attempt(call: Callable[[], Any], *, private: bool = False) -> Any:
    """The result of a call, or None if it raised an allowed exception.

    A public call must not raise the binding's text; a call of the private module (`private`) may.
    """
    try:
        return call()
    except KeyError:
        raise
    except ALLOWED as error:
        if not private and RAW in str(error) and "ale_py._ale_py" not in str(error):
            raise AssertionError(f"a public call raises the text of the binding: {error}") from error
        return None
