"""Emulator cores: the interface `Core`, and its three implementations.

`NativeCore` is our emulator, `PlainCore` our reference core, `AleCore` ale-py with checks; all give the same bytes.
`CORES` maps the values of the option `core` to them. ale-py is imported when `AleCore` is first used.
"""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from atari.base.extras import import_extra, pip_install
from atari.cores.core import ByteArray as ByteArray
from atari.cores.core import Core
from atari.cores.native import NativeCore, PlainCore

if TYPE_CHECKING:
    from atari.cores.ale import AleCore


class _Cores(Mapping[str, "type[NativeCore] | type[AleCore]"]):
    """The class of each value of the option `core`."""

    def __getitem__(self, name: str) -> "type[NativeCore] | type[AleCore]":
        return _ale_core() if name == "ale" else _OWN[name]

    def __iter__(self) -> Iterator[str]:
        return iter(("native", "ale", "plain"))

    def __len__(self) -> int:
        return 3


_OWN: dict[str, type[NativeCore]] = {"native": NativeCore, "plain": PlainCore}

CORES = _Cores()

__all__ = ["AleCore", "Core", "NativeCore", "PlainCore"]


def __getattr__(name: str) -> Any:
    if name == "AleCore":
        return _ale_core()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _ale_core() -> "type[AleCore]":
    import_extra("ale_py", f"core='ale' is ale-py's emulator: {pip_install('ale-py')}; core='native' needs no ale-py")
    from atari.cores.ale import AleCore

    return AleCore
