import cv2
import gymnasium
import numpy as np
import pytest

from atari.wrappers import Resize


def test_averages_areas(scripted):
    class OneImage(scripted):
        def _observation(self):
            return np.array([[0, 100, 10, 10], [100, 200, 10, 30]], np.uint8)

    env = Resize(OneImage(shape=(2, 4)), (1, 2))
    assert env.observation_space.shape == (1, 2)
    for observation in (env.reset()[0], env.step(0)[0]):
        np.testing.assert_array_equal(observation, [[100, 15]])


@pytest.mark.parametrize("obs_type", ["rgb", "grayscale"])
def test_is_gymnasiums(game_env, obs_type):
    ours = Resize(game_env("breakout", obs_type=obs_type), (84, 70))
    theirs = gymnasium.wrappers.ResizeObservation(game_env("breakout", obs_type=obs_type), (84, 70))
    assert ours.observation_space == theirs.observation_space
    np.testing.assert_array_equal(ours.reset(seed=0)[0], theirs.reset(seed=0)[0])
    for action in (1, 2, 3, 0) * 5:
        np.testing.assert_array_equal(ours.step(action)[0], theirs.step(action)[0])


def test_keeps_an_axis_of_one_colour(scripted):
    env = Resize(scripted(shape=(8, 8, 1)), (4, 2))
    env.reset()
    np.testing.assert_array_equal(env.step(0)[0], np.ones((4, 2, 1)))
    assert cv2.resize(np.ones((8, 8, 1), np.uint8), (2, 4)).shape == (4, 2), "which OpenCV does not"
