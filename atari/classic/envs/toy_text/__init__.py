"""Environments with finitely many states, which are Gymnasium's with the old interface, and their base."""

import copy
import inspect
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.envs import toy_text
from gymnasium.envs.toy_text.blackjack import draw_hand
from gymnasium.envs.toy_text.cliffwalking import DOWN, LEFT, RIGHT, UP

from atari.classic.envs.adapted import Adapted
from atari.classic.envs.toy_text import discrete

__all__ = ["BlackjackEnv", "CliffWalkingEnv", "FrozenLakeEnv", "TaxiEnv", "discrete"]


class Begun(Adapted):
    """An environment that has a state before the first `reset`, as in Gym: it can be rendered, set and stepped."""

    _is_begun = False

    def preview(self) -> None:
        """Put the environment at the start of its first episode, unless it is in it already."""
        if not (self._started or self._is_begun):
            super().preview()
            self._is_begun = True

    _before_reset = preview


class ToyText(Begun, discrete.DiscreteEnv):
    """A `Begun` environment with finitely many states."""

    @property
    def s(self) -> int:
        """The state; a script may set it, also before the first `reset`."""
        self.preview()
        return int(self.modern.unwrapped.s)  # type: ignore[attr-defined]

    @s.setter
    def s(self, state: int) -> None:
        self.preview()
        self.modern.unwrapped.s = state  # type: ignore[attr-defined]


_CHANGES = {UP: [-1, 0], RIGHT: [0, 1], DOWN: [1, 0], LEFT: [0, -1]}
"""The change of row and column by each action of `CliffWalkingEnv`."""


class BlackjackEnv(Begun):
    """Play Blackjack against a dealer.

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


class CliffWalkingEnv(ToyText):
    """Walk along a cliff (Sutton and Barto, example 6.6)."""

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


class FrozenLakeEnv(ToyText):
    """Cross a frozen lake with holes.

    Args:
        desc: the rows of the map, of S (start), F (frozen), H (hole) and G (goal); None means `map_name`.
        map_name: "4x4" or "8x8"; None means a random map.
        is_slippery: two moves of three go sideways.

    Example:
        >>> from atari import classic
        >>> env = classic.envs.toy_text.FrozenLakeEnv(is_slippery=False)
        >>> env.reset(), env.step(1)[:3]
        (0, (4, 0, False))
    """

    original = toy_text.FrozenLakeEnv
    cracked_hole_img = elf_images = goal_img = start_img = None  # Gym's pictures; Gymnasium draws others

    def __init__(
        self, desc: Sequence[str] | None = None, map_name: str | None = "4x4", is_slippery: bool = True
    ) -> None:
        super().__init__(desc=desc, map_name=map_name, is_slippery=is_slippery)


class TaxiEnv(ToyText):
    """Pick up a passenger and drop it at its goal (Dietterich 2000)."""

    original = toy_text.TaxiEnv
    median_horiz = median_vert = None  # Gym's pictures; Gymnasium draws others
