"""The console's colours: red, green and blue of each palette index, by TV format, from the emulator's tables.

The chip has 128 colours, 16 hues of 8 brightnesses, at the even indices. An odd index is its neighbour's luminance in
gray: PAL televisions lose colour when a frame has an odd number of lines.
"""

from collections.abc import Mapping
from types import MappingProxyType

from atari import _emulator
from atari.cores import ByteArray


def _palette(tv_format: str) -> ByteArray:
    palette = _emulator.palette(tv_format)
    palette.flags.writeable = False
    return palette


PALETTES: Mapping[str, ByteArray] = MappingProxyType({name: _palette(name) for name in ("NTSC", "PAL", "SECAM")})
"""(256, 3) uint8 by TV format."""
