"""`atomic` makes the calls of an object's methods run one at a time."""

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

_Self = TypeVar("_Self", bound=Any)
_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


def atomic(
    method: Callable[Concatenate[_Self, _Arguments], _Result],
) -> Callable[Concatenate[_Self, _Arguments], _Result]:
    """The method, which holds the lock `_lock` of its object."""

    @wraps(method)
    def locked(self: _Self, /, *arguments: _Arguments.args, **named: _Arguments.kwargs) -> _Result:
        with self._lock:
            return method(self, *arguments, **named)

    return locked
