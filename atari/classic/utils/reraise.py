"""`reraise`: the present exception, with more text."""

import sys
from types import TracebackType
from typing import NoReturn


def reraise(prefix: str | None = None, suffix: str | None = None) -> NoReturn:
    """Raise the present exception as a `ReraisedException`, with a text before and after it.

    Raises:
        ReraisedException: always.
        RuntimeError: there is no present exception; call it in an `except` block.
    """
    _, error, trace = sys.exc_info()
    if error is None:
        raise RuntimeError("reraise() is for an `except` block, and there is no exception")
    reraise_impl(ReraisedException(error, prefix, suffix), trace)


def reraise_impl(e: BaseException, traceback: TracebackType | None) -> NoReturn:
    """Raise an exception with a traceback."""
    raise e.with_traceback(traceback) from None


def full_class_name(o: object) -> str:
    """The name of an object's class, with its module unless it is one of Python's own."""
    kind = type(o)
    return kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__name__}"


class ReraisedException(Exception):
    """An exception with more text; `old_exc` is the original one."""

    def __init__(self, old_exc: BaseException, prefix: str | None, suffix: str | None) -> None:
        super().__init__(old_exc, prefix, suffix)
        self.old_exc, self.prefix, self.suffix = old_exc, prefix, suffix

    def __str__(self) -> str:
        original = f"The original exception was:\n\n{full_class_name(self.old_exc)}: {self.old_exc}"
        return "\n".join(filter(None, (self.prefix, original, self.suffix and f"\n{self.suffix}")))
