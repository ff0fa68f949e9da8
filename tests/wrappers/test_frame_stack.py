import pickle
from itertools import pairwise

import numpy as np
import pytest

from atari.wrappers import FrameStack
from atari.wrappers.frame_stack import LazyStack


def contents(observation):
    """The number each frame is filled with."""
    return [int(frame.max()) for frame in np.asarray(observation)]


@pytest.mark.parametrize("lazy", [False, True])
@pytest.mark.parametrize(("padding_type", "start"), [("reset", [5, 5, 5]), ("zero", [0, 0, 5])])
def test_stacks_the_last_frames_the_oldest_first(scripted, lazy, padding_type, start):
    class Five(scripted):
        def _observation(self):
            return super()._observation() + np.uint8(5)

    env = FrameStack(Five(), 3, padding_type, lazy=lazy)
    assert env.observation_space.shape == (3, 6, 4)
    for _ in range(2):  # a second episode starts with nothing of the first
        assert contents(env.reset()[0]) == start
        assert contents(env.step(0)[0]) == [*start[1:], 6]
        assert contents(env.step(0)[0]) == [start[2], 6, 7]
        assert contents(env.step(0)[0]) == [6, 7, 8]
        assert contents(env.step(0)[0]) == [7, 8, 9]


def test_arrays_are_new_and_may_be_written_to(scripted):
    env = FrameStack(scripted())
    first = env.reset()[0]
    second = env.step(0)[0]
    second[:] = 99
    assert contents(first) == [0, 0, 0, 0]
    assert contents(env.step(0)[0]) == [0, 0, 1, 2]
    assert contents(second) == [99] * 4


def test_one_frame_and_other_shapes(game_env):
    env = FrameStack(game_env("pong", obs_type="ram"), 1)
    observation, _ = env.reset(seed=0)
    np.testing.assert_array_equal(observation, env.unwrapped.core.ram()[None])
    assert env.observation_space.shape == (1, 128)


class TestLazyStack:
    @pytest.fixture
    def stacks(self, scripted):
        env = FrameStack(scripted(), lazy=True)
        return [env.reset()[0], *(env.step(0)[0] for _ in range(6))]

    def test_no_frame_is_copied(self, stacks):
        frames = {id(frame) for stack in stacks for frame in stack.frames}
        assert len(frames) == len(stacks)
        assert all(np.shares_memory(a[-1], b[-2]) for a, b in pairwise(stacks))

    def test_is_an_array_where_one_is_wanted(self, stacks):
        stack = stacks[5]
        array = np.array([np.full((6, 4), value) for value in (2, 3, 4, 5)], np.uint8)
        assert isinstance(stack, LazyStack)
        assert (stack.shape, stack.ndim, stack.dtype, len(stack)) == ((4, 6, 4), 3, np.uint8, 4)
        np.testing.assert_array_equal(np.asarray(stack), array)
        np.testing.assert_array_equal(np.stack([stack, stack]), np.stack([array, array]))
        np.testing.assert_array_equal(np.asarray(stack, np.float32) / 2, array / 2)
        np.testing.assert_array_equal(stack[-1], array[-1])
        np.testing.assert_array_equal(stack[1:, 0], array[1:, 0])
        assert (stack == array).all()
        assert not (stack == stacks[4]).all()
        assert repr(stack) == "LazyStack(shape=(4, 6, 4), dtype=uint8)"

    def test_frames_are_read_only(self, stacks):
        with pytest.raises(ValueError, match="read-only"):
            stacks[0][0][:] = 1

    def test_no_array_without_a_copy(self, stacks):
        with pytest.raises(ValueError, match="copy=False"):
            stacks[0].__array__(copy=False)

    def test_a_pickled_memory_holds_each_frame_once(self, scripted):
        env = FrameStack(scripted(shape=(84, 84)), lazy=True)
        memory = [env.reset()[0], *(env.step(0)[0] for _ in range(99))]
        data = pickle.dumps(memory)
        assert 100 * 84 * 84 < len(data) < 103 * 84 * 84
        again = pickle.loads(data)
        assert all((a == b).all() for a, b in zip(again, memory, strict=True))
