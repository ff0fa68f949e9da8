"""`OldAle`: `env.unwrapped.ale` with the names and arguments of atari-py."""

from collections.abc import Callable
from typing import Any

_RENAMED = {"getScreenRGB2": "getScreenRGB"}


class OldAle:
    """The methods of ale-py's interface, which also take texts as bytes, and `getScreenRGB2`.

    Args:
        interface: ale-py's interface, or an object of a script around it.
    """

    def __init__(self, interface: Any) -> None:
        self.interface = interface

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "interface":  # `copy` looks them up before they exist
            raise AttributeError(name)
        value = getattr(self.interface, _RENAMED.get(name, name))
        return _with_texts(value) if callable(value) else value


def _with_texts(method: Callable[..., Any]) -> Callable[..., Any]:
    """The method, with `bytes` among its arguments decoded."""

    def call(*arguments: Any, **options: Any) -> Any:
        return method(*(each.decode() if isinstance(each, bytes) else each for each in arguments), **options)

    return call
