"""How stacks follow from each other: `FrameStack`'s rules on numbers, and what one frame of each state cannot hold."""

import numpy as np
import pytest

from atari.recording.stacks import Stacking, next_stack, rows_of_stacks, stacking_of

STACK = np.array([[1], [2], [3]], np.uint8)


@pytest.mark.parametrize(
    ("stacking", "padding", "expected"),
    [
        (Stacking.ADDED, "zero", [2, 3, 9]),
        (Stacking.ADDED_TWICE, "zero", [3, 9, 9]),
        (Stacking.BEGUN, "zero", [0, 0, 9]),
        (Stacking.BEGUN, "reset", [9, 9, 9]),
    ],
)
def test_next_stack(stacking: Stacking, padding: str, expected: list[int]) -> None:
    following = next_stack(STACK, np.array([9], np.uint8), stacking, padding)
    assert following[:, 0].tolist() == expected
    assert stacking_of(STACK, following, stacking != Stacking.ADDED, padding) == stacking
    assert following.dtype == np.uint8


def test_stacks_of_one_frame() -> None:
    for stacking in Stacking:
        assert next_stack(STACK[:1], np.array([9], np.uint8), stacking, "zero").tolist() == [[9]]


def test_a_stack_with_several_new_frames_is_refused() -> None:
    with pytest.raises(ValueError, match="seamless_lives"):
        stacking_of(STACK, np.array([[3], [8], [9]], np.uint8), True, "zero")


def test_rows_of_stacks() -> None:
    stackings = np.array([1, 0, 2, 1, 0], np.uint8)
    assert rows_of_stacks(stackings, 3, "zero").tolist() == [
        [-1, -1, 0],
        [-1, 0, 1],
        [1, 2, 2],
        [-1, -1, 3],
        [-1, 3, 4],
    ]
    assert rows_of_stacks(stackings, 2, "reset").tolist() == [[0, 0], [0, 1], [2, 2], [3, 3], [3, 4]]
