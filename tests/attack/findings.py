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


def attempt(call: Callable[[], Any]) -> Any:
    """The result of a call, or None if it raised an allowed exception."""
    try:
        return call()
    except KeyError:
        raise
    except ALLOWED:
        return None
