"""`AcrobotEnv`: swing up two links by a motor between them."""

from gymnasium.envs import classic_control
from gymnasium.envs.classic_control.acrobot import bound, rk4, wrap

from atari.classic.envs.adapted import Adapted

__all__ = ["AcrobotEnv", "bound", "rk4", "wrap"]


class AcrobotEnv(Adapted):
    """Gymnasium's environment with the old interface."""

    original = classic_control.AcrobotEnv

    def __init__(self) -> None:
        super().__init__()
