"""Classic control: poles, hills and a pendulum."""

from atari.classic.envs.classic_control import rendering
from atari.classic.envs.classic_control.acrobot import AcrobotEnv
from atari.classic.envs.classic_control.cartpole import CartPoleEnv
from atari.classic.envs.classic_control.continuous_mountain_car import Continuous_MountainCarEnv
from atari.classic.envs.classic_control.mountain_car import MountainCarEnv
from atari.classic.envs.classic_control.pendulum import PendulumEnv

__all__ = [
    "AcrobotEnv",
    "CartPoleEnv",
    "Continuous_MountainCarEnv",
    "MountainCarEnv",
    "PendulumEnv",
    "rendering",
]
