"""`PendulumEnv`: swing up a pendulum."""

from gymnasium.envs import classic_control
from gymnasium.envs.classic_control.pendulum import DEFAULT_X, DEFAULT_Y, angle_normalize

from atari.classic.envs.adapted import Adapted

__all__ = ["DEFAULT_X", "DEFAULT_Y", "PendulumEnv", "angle_normalize"]


class PendulumEnv(Adapted):
    """Gymnasium's environment with the old interface.

    Args:
        g: gravity.
    """

    original = classic_control.PendulumEnv

    def __init__(self, g: float = 10.0) -> None:
        super().__init__(g=g)
