"""`Resize`: scale images down, to 84x84 since the first deep Q-network (Mnih et al. 2013)."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari.base.validation import check_integer
from atari.cores import ByteArray
from atari.env.restorable import RestorableWrapper
from atari.wrappers._checks import Environment, require_image, require_pixels
from atari.wrappers.images import resize_image


class Resize(RestorableWrapper, gymnasium.ObservationWrapper[Any, Any, Any]):
    """Scale images to `shape` by `resize_image`, which averages areas (OpenCV's INTER_AREA).

    It equals Gymnasium's `ResizeObservation`, which cannot be pickled.

    Args:
        env: an environment with observations (rows, columns) or (rows, columns, colours).
        shape: (rows, columns) of the result.

    Raises:
        TypeError, ValueError: the observations are not images, or `shape` is not two integers of 1 or more.

    Example:
        >>> import atari
        >>> from atari.wrappers import Resize
        >>> Resize(atari.make("pong", obs_type="grayscale"), (84, 84)).reset(seed=0)[0].shape
        (84, 84)
    """

    def __init__(self, env: Environment, shape: tuple[int, int] = (84, 84)) -> None:
        self._source = require_pixels(env, "Resize")
        if not isinstance(shape, (tuple, list)) or len(shape) != 2:
            raise TypeError(f"shape must be two integers (rows, columns), got {shape!r}")
        rows, columns = (check_integer("shape", length, 1, 10_000) for length in shape)
        super().__init__(env, shape=(rows, columns))
        self._size = rows, columns
        self._shape = (rows, columns, *self._source[2:])
        self.observation_space = spaces.Box(0, 255, self._shape, np.uint8)

    def observation(self, observation: ByteArray) -> ByteArray:
        """The scaled image, uint8 of the shape of the space.

        Raises:
            TypeError, ValueError: the observation is no image of the wrapped environment's space.
        """
        require_image(observation, self._source, "Resize")
        return resize_image(observation, self._size)
