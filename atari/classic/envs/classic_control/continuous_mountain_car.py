"""`Continuous_MountainCarEnv`: drive up a hill, with a force of any size."""

from gymnasium.envs import classic_control

from atari.classic.envs.adapted import Adapted


class Continuous_MountainCarEnv(Adapted):
    """Gymnasium's environment with the old interface.

    Args:
        goal_velocity: the least velocity at the goal.
    """

    original = classic_control.Continuous_MountainCarEnv

    def __init__(self, goal_velocity: float = 0) -> None:
        super().__init__(goal_velocity=goal_velocity)
