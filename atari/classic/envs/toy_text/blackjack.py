"""`BlackjackEnv`: play Blackjack against a dealer."""

from gymnasium.envs import toy_text

from atari.classic.envs.adapted import Adapted


class BlackjackEnv(Adapted):
    """Gymnasium's environment with the old interface.

    Args:
        natural: an ace and a ten at the start win 1.5.
    """

    original = toy_text.BlackjackEnv

    def __init__(self, natural: bool = False) -> None:
        super().__init__(natural=natural)
