"""Emulator cores: what an environment needs of an emulator (`Core`), and the ones there are.

`AleCore` is ale-py behind that interface, guarded. `CORES` has them by the name that `core=` takes.
"""

from collections.abc import Mapping
from types import MappingProxyType

from atari.cores.ale import AleCore
from atari.cores.protocol import ByteArray, Core

CORES: Mapping[str, type[AleCore]] = MappingProxyType({"ale": AleCore})

__all__ = ["CORES", "AleCore", "ByteArray", "Core"]
