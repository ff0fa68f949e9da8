import numpy as np
import pytest

from atari.wrappers import Grayscale


class Colours:
    """Red, green, blue and a mixture, and their luminance."""

    rgb = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [200, 72, 72]]], np.uint8)
    gray = np.array([[76, 150], [29, 110]], np.uint8)


@pytest.mark.parametrize("keep_dim", [False, True])
def test_luminance(scripted, keep_dim):
    class OneImage(scripted):
        def _observation(self):
            return Colours.rgb

    env = Grayscale(OneImage(shape=(2, 2, 3)), keep_dim)
    expected = Colours.gray[..., None] if keep_dim else Colours.gray
    assert env.observation_space.shape == expected.shape
    for observation in (env.reset()[0], env.step(0)[0]):
        assert observation.dtype == np.uint8
        np.testing.assert_array_equal(observation, expected)


def test_is_near_ales_own_table(game_env):
    gray, ale = Grayscale(game_env("seaquest")), game_env("seaquest", obs_type="grayscale")
    ours, theirs = gray.reset(seed=0)[0], ale.reset(seed=0)[0]
    assert ours.shape == theirs.shape == (210, 160)
    assert np.abs(ours.astype(int) - theirs).max() <= 1
