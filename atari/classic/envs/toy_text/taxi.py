"""`TaxiEnv`: pick up a passenger and drop it at its goal (Dietterich 2000)."""

from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.taxi import MAP, WINDOW_SIZE

from atari.classic.envs.toy_text.adapted import ToyText

__all__ = ["MAP", "WINDOW_SIZE", "TaxiEnv"]


class TaxiEnv(ToyText):
    """Gymnasium's environment with the old interface."""

    original = toy_text.TaxiEnv
    median_horiz = median_vert = None  # Gym's pictures; Gymnasium draws others

    def __init__(self) -> None:
        super().__init__()
