"""`CartPoleEnv`: balance a pole on a cart."""

from gymnasium.envs import classic_control

from atari.classic.envs.adapted import Adapted


class CartPoleEnv(Adapted):
    """Gymnasium's environment with the old interface.

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

    def __init__(self) -> None:
        super().__init__()

    @property
    def steps_beyond_done(self) -> int | None:
        """The steps after the end of the episode; None before it. A script may assign it."""
        return self.modern.unwrapped.steps_beyond_terminated  # type: ignore[attr-defined, no-any-return]

    @steps_beyond_done.setter
    def steps_beyond_done(self, steps: int | None) -> None:
        self.modern.unwrapped.steps_beyond_terminated = steps  # type: ignore[attr-defined]
