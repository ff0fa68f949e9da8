"""Images of every size: a vector's equal a single environment's, and OpenCV's of the whole screens."""

import cv2
import numpy as np
import pytest

import atari
from atari.task.fields import CHECKS


@pytest.mark.parametrize("obs_type", ["grayscale", "rgb"])
@pytest.mark.parametrize("size", [(12, 11), (5, 11), (7, 3), (1, 1), (2, 80), (210, 2), (3, 159)])
def test_a_vector_plays_every_size(size: tuple[int, int], obs_type: str) -> None:
    height, width = size
    whole = {"obs_type": obs_type, "stack_num": 1, "maxpool": True}
    task = atari.Task.of("kaboom", **whole, img_height=height, img_width=width)
    envs, screens = (atari.AtariVectorEnv(each, 3) for each in (task, atari.Task.of("kaboom", **whole)))
    single = atari.make(task)
    observations = envs.reset(seed=5)[0], screens.reset(seed=5)[0], single.reset(seed=6)[0]
    for number in range(20):
        images = [cv2.resize(screen, (width, height), interpolation=cv2.INTER_AREA) for (screen,) in observations[1]]
        np.testing.assert_array_equal(observations[0], np.reshape(images, observations[0].shape))
        np.testing.assert_array_equal(observations[0][1], observations[2])
        actions = np.full(3, number % 4)
        observations = envs.step(actions)[0], screens.step(actions)[0], single.step(number % 4)[0]


def test_the_widths_are_those_of_the_field() -> None:
    width = CHECKS["img_width"].check
    for wrong in (width.low - 1, width.high + 1):
        with pytest.raises(ValueError, match="img_width must be within 1"):
            atari.AtariVectorEnv("pong", 1, img_width=wrong)
    assert atari.AtariVectorEnv("pong", 1, img_width=width.low).reset(seed=0)[0].shape == (1, 4, 84, width.low)
