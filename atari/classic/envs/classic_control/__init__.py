"""Classic control: poles, hills and a pendulum, which are Gymnasium's environments with the old interface."""

from gymnasium.envs import classic_control

from atari.classic.envs.adapted import Adapted
from atari.classic.envs.classic_control import rendering

__all__ = [
    "AcrobotEnv",
    "CartPoleEnv",
    "Continuous_MountainCarEnv",
    "MountainCarEnv",
    "PendulumEnv",
    "rendering",
]


class AcrobotEnv(Adapted):
    """Swing up two links by a motor between them."""

    original = classic_control.AcrobotEnv


class CartPoleEnv(Adapted):
    """Balance a pole on a cart.

    Example:
        >>> from atari import classic
        >>> class Moon(classic.envs.classic_control.CartPoleEnv):
        ...     def __init__(self):
        ...         super().__init__()
        ...         self.gravity = 1.6
        >>> env = Moon()
        >>> env.reset().shape, env.gravity
        ((4,), 1.6)
    """

    original = classic_control.CartPoleEnv

    @property
    def steps_beyond_done(self) -> int | None:
        """The steps after the end of the episode; None before it. A script may assign it."""
        return self.modern.unwrapped.steps_beyond_terminated  # type: ignore[attr-defined]

    @steps_beyond_done.setter
    def steps_beyond_done(self, steps: int | None) -> None:
        self.modern.unwrapped.steps_beyond_terminated = steps  # type: ignore[attr-defined]


class Continuous_MountainCarEnv(Adapted):
    """Drive up a hill, with a force of any size.

    Args:
        goal_velocity: the least velocity at the goal.
    """

    original = classic_control.Continuous_MountainCarEnv

    def __init__(self, goal_velocity: float = 0) -> None:
        super().__init__(goal_velocity=goal_velocity)


class MountainCarEnv(Adapted):
    """Drive up a hill.

    Args:
        goal_velocity: the least velocity at the goal.
    """

    original = classic_control.MountainCarEnv

    def __init__(self, goal_velocity: float = 0) -> None:
        super().__init__(goal_velocity=goal_velocity)


class PendulumEnv(Adapted):
    """Swing up a pendulum.

    Args:
        g: gravity.
    """

    original = classic_control.PendulumEnv

    def __init__(self, g: float = 10.0) -> None:
        super().__init__(g=g)
