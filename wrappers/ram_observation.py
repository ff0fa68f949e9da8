"""`RamObservation`: the 128 bytes of RAM beside the pixels."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from atari.env.restorable import RestorableWrapper
from atari.wrappers._checks import Environment, require_atari


class RamObservation(RestorableWrapper, gymnasium.ObservationWrapper[Any, Any, Any]):
    """Observations become `{"image": the pixels, "ram": (128,) uint8}`.

    The RAM is read at the time of the observation. With `sound_obs`, "ram" joins "image" and "sound". Put it outside
    the wrappers that work on pixels; `atari.games[game].ram_labels` has the meaning of the bytes.

    Raises:
        TypeError: the environment is not an `AtariEnv`.
        ValueError: the observations are RAM already.

    Example:
        >>> import atari
        >>> from atari.wrappers import RamObservation
        >>> observation, _ = RamObservation(atari.make("pong")).reset(seed=0)
        >>> {name: array.shape for name, array in observation.items()}
        {'image': (210, 160, 3), 'ram': (128,)}
    """

    def __init__(self, env: Environment) -> None:
        self._atari = require_atari(env, "RamObservation")
        ram = spaces.Box(0, 255, (128,), np.uint8)
        if env.observation_space == ram:
            raise ValueError("the observations are RAM already; make the environment with obs_type='rgb' to have both")
        super().__init__(env)
        space = env.observation_space
        self._with_sound = isinstance(space, spaces.Dict)
        parts = space.spaces if isinstance(space, spaces.Dict) else {"image": space}
        self.observation_space = spaces.Dict({**parts, "ram": ram})

    def observation(self, observation: Any) -> dict[str, Any]:
        """The observation with the RAM."""
        parts = observation if self._with_sound else {"image": observation}
        return {**parts, "ram": self._atari.driver.observed.ram()}
