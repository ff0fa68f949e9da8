import numpy as np
import pytest

from atari.wrappers import FrameSkip


def test_plays_the_action_so_often_and_sums_the_rewards(scripted):
    env = FrameSkip(scripted(rewards={1: 1.0, 4: 2.0, 5: 4.0}), frame_skip=4)
    env.reset()
    _, reward, terminated, truncated, info = env.step(3)
    assert env.unwrapped.actions == [3] * 4
    assert (reward, terminated, truncated, info["frame"]) == (3.0, False, False, 4)
    assert env.step(2)[1] == 4.0


@pytest.mark.parametrize(("max_pool", "expected"), [(True, [[1, 8], [1, 7]]), (False, [[1, 8], [0, 0]])])
def test_shows_the_maximum_of_the_last_two(scripted, max_pool, expected):
    frames = {3: [[0, 5], [1, 7]], 4: [[1, 8], [0, 0]]}

    class Blinking(scripted):
        def _observation(self):
            return np.array(frames.get(self.frame, [[9, 9], [9, 9]]), np.uint8)

    env = FrameSkip(Blinking(shape=(2, 2)), frame_skip=4, max_pool=max_pool)
    env.reset()
    np.testing.assert_array_equal(env.step(0)[0], expected)


@pytest.mark.parametrize(("end", "flags"), [("ends", (True, False)), ("limit", (False, True))])
@pytest.mark.parametrize("frame", [1, 2, 3])
def test_stops_at_the_end_and_shows_it(scripted, end, flags, frame):
    env = FrameSkip(scripted(rewards={1: 1.0, 2: 1.0, 3: 1.0, 4: 1.0}, **{end: frame}))
    env.reset()
    observation, reward, *ended, info = env.step(1)
    assert (observation.max(), reward, tuple(ended), info["frame"]) == (frame, frame, flags, frame)


def test_one_frame_is_left_as_it_is(scripted):
    env = FrameSkip(scripted(), frame_skip=1)
    env.reset()
    assert env.step(0)[0].max() == 1
    assert env.step(0)[0].max() == 2


def test_ram_is_not_pooled(game_env):
    env = FrameSkip(game_env("pong", obs_type="ram"), max_pool=False)
    env.reset(seed=0)
    np.testing.assert_array_equal(env.step(0)[0], env.unwrapped.core.ram())
