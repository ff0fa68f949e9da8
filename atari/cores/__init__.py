"""Emulator cores: what an environment needs of an emulator (`Core`), and the ones there are.

`NativeCore` is our own emulator, `PlainCore` is the same without its shortcuts, `AleCore` is ale-py behind the same
interface, guarded; they are equal to the bit.
`CORES` has them by the name that `core=` takes.
"""

from collections.abc import Mapping
from types import MappingProxyType

from atari.cores.ale import AleCore
from atari.cores.native import NativeCore, PlainCore
from atari.cores.protocol import ByteArray, Core

CORES: Mapping[str, type[NativeCore] | type[AleCore]] = MappingProxyType(
    {"native": NativeCore, "ale": AleCore, "plain": PlainCore}
)

__all__ = ["CORES", "AleCore", "ByteArray", "Core", "NativeCore", "PlainCore"]
