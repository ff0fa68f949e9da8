"""The sound of the page: the worklet plays without a gap or a click, although its clock is not that of the screen."""

import math
import shutil

import pytest
from web_tools import node

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="needs Node; scripts/test --web runs this test")

LARGEST = 0.6 * 60 / 128 * 2 * math.pi * 440 / 48000
"""The largest step of the tone itself, a sine of 440 Hz at 48 kHz."""


def test_a_tone_has_no_gap_and_no_click() -> None:
    cases = [{"drift": drift, "late": late} for drift in (1, 0.997, 1.003) for late in (0, 7, 60)]
    for case, heard in zip(cases, node("play_sound.mjs", seconds=60, cases=cases), strict=True):
        assert heard["stops"] == 0, case
        assert 0.9 * LARGEST < heard["step"] < 1.3 * LARGEST, case  # samples have 8 bits


def test_sound_that_does_not_come_stops_without_a_click() -> None:
    (heard,) = node("play_sound.mjs", seconds=10, cases=[{"drift": 0.9, "late": 0}])
    assert heard["stops"] > 0
    assert heard["step"] < 6 * LARGEST
