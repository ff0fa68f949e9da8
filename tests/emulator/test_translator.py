"""The JIT translator's assembler. What translated code does is tested in test_fast_equals_plain.py."""

import atari_inspection
import pytest


@pytest.mark.parametrize("distance", [0, 1, 126, 127])
def test_short_jumps(distance: int) -> None:
    """JZ, the distance, and the skipped bytes."""
    assert atari_inspection.short_jump(distance) == bytes([0x74, distance]) + b"\xc3" * distance


@pytest.mark.parametrize("distance", [128, 129, 255, 256, 1000])
def test_short_jumps_that_would_lead_too_far(distance: int) -> None:
    """A distance of 128 would jump backwards, one of 256 would skip nothing."""
    with pytest.raises(RuntimeError, match="a short jump leads too far"):
        atari_inspection.short_jump(distance)
