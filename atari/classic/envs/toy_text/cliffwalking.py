"""`CliffWalkingEnv`: walk along a cliff (Sutton and Barto, example 6.6)."""

from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.cliffwalking import DOWN, LEFT, RIGHT, UP

from atari.classic.envs.toy_text.adapted import ToyText

__all__ = ["DOWN", "LEFT", "RIGHT", "UP", "CliffWalkingEnv"]


class CliffWalkingEnv(ToyText):
    """Gymnasium's environment with the old interface."""

    original = toy_text.CliffWalkingEnv

    def __init__(self) -> None:
        super().__init__()
