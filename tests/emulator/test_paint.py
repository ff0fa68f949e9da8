"""Rendering spans and converting colours: every SIMD level gives the bytes of a simple version in NumPy."""

import atari_inspection
import numpy as np
import pytest
from atari_inspection import SimdLevel

import atari._emulator as _emulator
from atari.cores import ByteArray

LEVELS = [level for level in SimdLevel if level.value <= atari_inspection.best_simd_level().value]
"""The SIMD levels that this processor supports."""

RANDOM = np.random.default_rng(20)


def random_layers() -> list[ByteArray]:
    """Three layers, dense or sparse; no two of them share a pixel."""
    owner = RANDOM.choice(4, size=160, p=RANDOM.dirichlet([0.5] * 4))
    return [(owner == layer).astype(np.uint8) for layer in range(3)]


def expected_row(layers: list[ByteArray], colours: list[int], first: int, last: int) -> ByteArray:
    """The same span, pixel by pixel."""
    row = np.zeros(160, np.uint8)
    for x in range(first, last):
        row[x] = next((colour for layer, colour in zip(layers, colours[:3], strict=True) if layer[x]), colours[3])
    return row


@pytest.mark.parametrize("level", LEVELS)
def test_every_level_paints_the_same(level: SimdLevel) -> None:
    """Whole lines, single pixels at both edges, and random spans."""
    spans = [(0, 160), (0, 1), (159, 160), (63, 65), (31, 33), (127, 129)]
    spans += [(first, int(RANDOM.integers(first + 1, 161))) for first in RANDOM.integers(0, 160, size=300)]
    for first, last in spans:
        layers = random_layers()
        colours = [int(colour) for colour in RANDOM.integers(0, 256, size=4)]
        row = atari_inspection.paint(layers, colours, int(first), last, level)
        np.testing.assert_array_equal(row, expected_row(layers, colours, int(first), last))


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("tv_format", ["NTSC", "PAL", "SECAM"])
def test_colours_are_those_of_the_palette(tv_format: str, level: SimdLevel) -> None:
    """Noise of all indices, and frames whose rows mostly repeat; also heights whose pixels are no multiple of 64."""
    for rows in (1, 2, 3, 200, 210, 250, 300):
        noise = RANDOM.integers(0, 256, size=(rows, 160), dtype=np.uint8)
        repeated = np.repeat(RANDOM.integers(0, 256, size=(rows // 7 + 1, 160), dtype=np.uint8), 7, axis=0)[
            :rows
        ].copy()
        repeated[rows // 2, 40:43] ^= 2
        for frame in (noise, repeated):
            rgb = atari_inspection.to_rgb(frame, tv_format, level)
            np.testing.assert_array_equal(rgb, _emulator.palette(tv_format)[frame])
