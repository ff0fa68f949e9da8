"""`BlackjackEnv`: play Blackjack against a dealer."""

import copy
from typing import Any

from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.blackjack import draw_hand

from atari.classic.envs.adapted import Adapted


class BlackjackEnv(Adapted):
    """Gymnasium's environment with the old interface.

    Args:
        natural: an ace and a ten at the start win 1.5.
    """

    original = toy_text.BlackjackEnv

    def __init__(self, natural: bool = False) -> None:
        super().__init__(natural=natural)

    def reset(self, **options: Any) -> Any:
        """Deal the hands of the dealer and of the player, and return what the player sees."""
        generator = copy.deepcopy(self.np_random)
        observation = super().reset(**options)
        for _ in range(2):
            draw_hand(generator)  # type: ignore[no-untyped-call]
        self.np_random = generator  # Gymnasium draws more, for its picture of the dealer's card; Gym did not
        return observation
