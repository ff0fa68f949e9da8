"""`Grayscale`: one brightness for each pixel instead of three colours."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari.cores import ByteArray
from atari.env.restorable import RestorableWrapper
from atari.wrappers._checks import Environment, require_image, require_pixels
from atari.wrappers.images import rgb_to_gray


class Grayscale(RestorableWrapper, gymnasium.ObservationWrapper[Any, Any, Any]):
    """RGB images (rows, columns, 3) become gray ones (rows, columns), uint8, by `rgb_to_gray`.

    The brightness is OpenCV's, as in OpenAI's Baselines. ALE has its own table of gray values, which differ a
    little: for them make the environment with `obs_type="grayscale"`. (Gymnasium's `GrayscaleObservation` uses other
    weights, computes in float64, which is slow, and cannot be pickled.)

    Args:
        env: an environment with RGB observations.
        keep_dim: keep the last axis, (rows, columns, 1).

    Raises:
        TypeError: `keep_dim` is no bool.
        ValueError: the observations are not RGB images.

    Example:
        >>> import atari
        >>> from atari.wrappers import Grayscale
        >>> Grayscale(atari.make("pong")).reset(seed=0)[0].shape
        (210, 160)
    """

    def __init__(self, env: Environment, keep_dim: bool = False) -> None:
        if not isinstance(keep_dim, (bool, np.bool_)):
            raise TypeError(f"keep_dim must be True or False, got {keep_dim!r}")
        self._source = shape = require_pixels(env, "Grayscale")
        if shape[2:] != (3,):
            raise ValueError(f"Grayscale needs RGB images (rows, columns, 3), got shape {shape}; leave it out")
        super().__init__(env, keep_dim=keep_dim)
        self._shape = shape[:2] + ((1,) if keep_dim else ())
        self.observation_space = spaces.Box(0, 255, self._shape, np.uint8)

    def observation(self, observation: ByteArray) -> ByteArray:
        """The gray image, uint8 of the shape of the space.

        Raises:
            TypeError, ValueError: the observation is no image of the wrapped environment's space.
        """
        require_image(observation, self._source, "Grayscale")
        return rgb_to_gray(observation).reshape(self._shape)
