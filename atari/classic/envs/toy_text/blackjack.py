"""`BlackjackEnv`: play Blackjack against a dealer."""

import copy
from typing import Any

from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.blackjack import (
    cmp,
    deck,
    draw_card,
    draw_hand,
    is_bust,
    is_natural,
    score,
    sum_hand,
    usable_ace,
)

from atari.classic.envs.adapted import Adapted

__all__ = [
    "BlackjackEnv",
    "cmp",
    "deck",
    "draw_card",
    "draw_hand",
    "is_bust",
    "is_natural",
    "score",
    "sum_hand",
    "usable_ace",
]


class BlackjackEnv(Adapted):
    """Gymnasium's environment with the old interface.

    Args:
        natural: an ace and a ten at the start win 1.5.
        sab: the rules of Sutton and Barto: an ace and a ten at the start win, unless the dealer has them too.
    """

    original = toy_text.BlackjackEnv

    def __init__(self, natural: bool = False, sab: bool = False) -> None:
        super().__init__(natural=natural, sab=sab)

    def reset(self, **options: Any) -> Any:
        """Deal the hands of the dealer and of the player, and return what the player sees."""
        generator = copy.deepcopy(self.np_random)
        observation = super().reset(**options)
        for _ in range(2):
            draw_hand(generator)  # type: ignore[no-untyped-call]
        self.np_random = generator  # Gymnasium draws more, for its picture of the dealer's card; Gym did not
        return observation
