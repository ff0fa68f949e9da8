"""`with_readable_errors`: methods of the extension module whose refusals of arguments a user can read."""

import functools
import re
from collections.abc import Callable
from typing import Any, TypeVar

_Class = TypeVar("_Class", bound=type)

FAST = {"act", "act_until", "reset", "ram", "audio", "screen", "screen_rgb", "screen_grayscale", "redraw"}
"""Methods that are called for each frame. They convert their arguments themselves, and have no wrapper."""


def with_readable_errors(kind: _Class) -> _Class:
    """Replace the methods that a class inherits from the extension module, except the fast ones.

    If the binding refuses the number or the types of the arguments, a TypeError with one sentence says which it takes.
    """
    for name in dir(kind):
        method = getattr(kind, name)
        if not name.startswith("_") and name not in FAST and hasattr(method, "__nb_signature__"):
            setattr(kind, name, _readable(method))
    return kind


def _readable(method: Any) -> Callable[..., Any]:
    takes = re.sub(r"\b(?:[A-Za-z_]\w*\.)+(?=[A-Za-z_])", "", method.__nb_signature__[0][0])
    takes = re.sub(r"\\\d+", "...", takes.removeprefix("def ").partition(" -> ")[0]).replace("(self, ", "(")
    takes = takes.replace("(self)", "()")

    @functools.wraps(method)
    def call(self: Any, *arguments: Any, **named: Any) -> Any:
        try:
            return method(self, *arguments, **named)
        except TypeError as error:
            if "incompatible function arguments" not in str(error):
                raise
        given = [repr(value)[:40] for value in arguments] + [f"{name}={value!r:.40}" for name, value in named.items()]
        raise TypeError(f"the core's method is {takes}, got ({', '.join(given)})")

    return call
