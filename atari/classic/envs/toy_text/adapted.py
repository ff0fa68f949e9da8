"""`ToyText`: the base of Gymnasium's environments with finitely many states, with the old interface."""

from atari.classic.envs.adapted import Adapted
from atari.classic.envs.toy_text.discrete import DiscreteEnv


class ToyText(Adapted, DiscreteEnv):
    """An environment that has a state before the first `reset`, as in Gym."""

    @property
    def s(self) -> int:
        """The state; a script may set it."""
        if not hasattr(self.modern.unwrapped, "s"):
            self.preview()
        return int(self.modern.unwrapped.s)  # type: ignore[attr-defined]

    @s.setter
    def s(self, state: int) -> None:
        self.modern.unwrapped.s = state  # type: ignore[attr-defined]
