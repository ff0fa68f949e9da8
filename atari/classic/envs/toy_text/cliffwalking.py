"""`CliffWalkingEnv`: walk along a cliff (Sutton and Barto, example 6.6)."""

import inspect
from typing import Any

import numpy as np
from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.cliffwalking import DOWN, LEFT, RIGHT, UP

from atari.classic.envs.toy_text.adapted import ToyText

_CHANGES = {UP: [-1, 0], RIGHT: [0, 1], DOWN: [1, 0], LEFT: [0, -1]}
"""The change of row and column by each action."""

__all__ = ["DOWN", "LEFT", "RIGHT", "UP", "CliffWalkingEnv"]


class CliffWalkingEnv(ToyText):
    """Gymnasium's environment with the old interface."""

    original = toy_text.CliffWalkingEnv
    cliff_img = elf_images = mountain_bg_img = near_cliff_img = tree_img = (
        None  # Gym's pictures; Gymnasium draws others
    )

    def __init__(self) -> None:
        super().__init__()
        if type(self)._calculate_transition_prob is CliffWalkingEnv._calculate_transition_prob:
            return
        table: Any = self.P
        for state in range(self.nS):  # a subclass has other transitions
            place = np.array(np.unravel_index(state, self.shape))
            table[state] = {
                action: self._calculate_transition_prob(place, list(delta)) for action, delta in _CHANGES.items()
            }

    def _calculate_transition_prob(self, current: Any, delta: Any) -> Any:
        """The transitions from (row, column) by a change of them; a subclass may replace it."""
        (move,) = (each for each, change in _CHANGES.items() if list(change) == list(delta))
        env: Any = self.modern.unwrapped
        calculate = self.original._calculate_transition_prob
        takes_delta = "delta" in inspect.signature(calculate).parameters  # in Gymnasium before 1.0
        return calculate(env, current, delta if takes_delta else move)
