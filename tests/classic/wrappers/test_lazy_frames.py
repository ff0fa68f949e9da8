"""`LazyFrames`: stacks that share their frames."""

import copy
import pickle

import numpy as np
import pytest

import atari.classic as gym
from atari.classic.wrappers.frame_stack import FrameStack, LazyFrames


def test_it_is_the_array_of_its_frames() -> None:
    frames = [np.full((2, 3), i, np.uint8) for i in range(4)]
    stack = LazyFrames(frames)
    array = np.stack(frames)
    assert (stack.shape, stack.frame_shape, stack.dtype, len(stack)) == ((4, 2, 3), (2, 3), np.uint8, 4)
    for made in (np.array(stack), np.asarray(stack), stack[:], stack.__array__(), np.array(stack, copy=False)):
        np.testing.assert_array_equal(made, array)
    assert np.asarray(stack, np.float32).dtype == np.float32
    np.testing.assert_array_equal(stack[1:3, 0], array[1:3, 0])
    assert stack[-1] is frames[-1]
    assert (stack == array).all()


@pytest.mark.parametrize("make_copy", [copy.deepcopy, lambda stack: pickle.loads(pickle.dumps(stack))])
def test_copies(make_copy: object) -> None:
    stack = LazyFrames([np.ones(3), np.zeros(3)])
    np.testing.assert_array_equal(make_copy(stack), stack)  # type: ignore[operator]


def test_stacks_share_frames() -> None:
    env = FrameStack(gym.make("Pong-v4"), 3)
    first = env.reset()
    second = env.step(0)[0]
    assert type(first) is type(second) is gym.wrappers.LazyFrames
    assert second[0] is first[1]
    assert len(env.frames) == 3


@pytest.mark.parametrize("wrong", [0, -2])
def test_wrong_numbers(wrong: int) -> None:
    with pytest.raises(ValueError, match=rf"^num_stack is a number of observations, 1 or more, got {wrong}$"):
        FrameStack(gym.make("Pong-v4"), wrong)


def test_only_boxes_are_stacked() -> None:
    with pytest.raises(TypeError, match=r"^FrameStack stacks the arrays of a Box space, got Discrete\(16\)$"):
        FrameStack(gym.make("FrozenLake-v1"), 2)
