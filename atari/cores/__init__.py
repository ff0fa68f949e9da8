"""Emulator cores: the interface `Core`, and its three implementations.

`NativeCore` is our emulator, `PlainCore` our reference core, `AleCore` ale-py with checks; all give the same bytes.
`CORES` maps the values of the option `core` to them.
"""

from collections.abc import Mapping

from atari.base.frozen import FrozenDict
from atari.cores.ale import AleCore
from atari.cores.core import ByteArray as ByteArray
from atari.cores.core import Core
from atari.cores.native import NativeCore, PlainCore

_BY_NAME: dict[str, type[NativeCore] | type[AleCore]] = {"native": NativeCore, "ale": AleCore, "plain": PlainCore}

CORES: Mapping[str, type[NativeCore] | type[AleCore]] = FrozenDict(_BY_NAME)
"""The class of each value of the option `core`."""

__all__ = ["AleCore", "Core", "NativeCore", "PlainCore"]
