"""`ClipReward`: clip rewards to -1..1, so that one learning rate fits all games (Mnih et al. 2015)."""

import math
from collections.abc import Callable
from typing import Any, SupportsFloat

import gymnasium

from atari.env.restorable import RestorableWrapper
from atari.wrappers._checks import Environment


class ClipReward(RestorableWrapper, gymnasium.RewardWrapper[Any, Any]):
    """Clip each reward to `min_reward`..`max_reward`, None for no limit; the result is a Python float.

    Scores are whole numbers, for which clipping to -1..1 and taking the sign (as Baselines does) are the same.
    Gymnasium's `ClipReward` computes the same, but keeps a lambda and so cannot be pickled.

    Raises:
        ValueError: `min_reward` is not less than `max_reward`.

    Example:
        >>> import atari
        >>> from atari.wrappers import ClipReward
        >>> env = ClipReward(atari.make("ms_pacman"))
        >>> env.reset(seed=0)[0].shape
        (210, 160, 3)
        >>> env.reward(50), env.reward(-3), env.reward(0)
        (1.0, -1.0, 0.0)
    """

    def __init__(self, env: Environment, min_reward: float | None = -1.0, max_reward: float | None = 1.0) -> None:
        low = -math.inf if min_reward is None else float(min_reward)
        high = math.inf if max_reward is None else float(max_reward)
        if not low < high:
            raise ValueError(f"min_reward must be less than max_reward, got {min_reward} and {max_reward}")
        super().__init__(env, min_reward=min_reward, max_reward=max_reward)
        self._min, self._max = low, high

    @property
    def func(self) -> Callable[[SupportsFloat], float]:
        """The function that clips, as Gymnasium's wrapper names it."""
        return self.reward

    def reward(self, reward: SupportsFloat) -> float:
        """The reward, clipped."""
        return min(max(float(reward), self._min), self._max)
