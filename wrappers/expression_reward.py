"""`ExpressionReward`: an expression over the game's reward, lives and RAM, before and after a step, is the reward."""

from typing import Any

import gymnasium
import numpy as np

from atari.cores.compiled import reward_formula
from atari.env.episode_env import EpisodeEnv
from atari.env.restorable import RestorableWrapper, State, layers
from atari.games.rewards import as_one_line
from atari.wrappers._checks import Environment, require_atari


class ExpressionReward(RestorableWrapper):
    """Pay the value of an expression, which docs/rewards.md describes, instead of the game's reward.

    The value is a Python float, computed once a step: put it outside a frame skip, and `ClipReward` around it.
    `atari.make(..., reward=...)` does both. The task's field `reward` is the same in a vector.

    Args:
        env: an `AtariEnv` with wrappers that do not change the reward. `info["reward"]` is the game's.
        reward: the expression, such as "reward - 5 * lives_lost" or "0.1 * (player_y - before.player_y)".

    Raises:
        TypeError: the environment is no `AtariEnv`, or the expression no string.
        ValueError: the expression is outside the language; the message has the column. Or a wrapper changes the reward.

    Example:
        >>> import atari
        >>> from atari.wrappers import ExpressionReward
        >>> env = ExpressionReward(atari.make("breakout"), "reward - 5 * lives_lost")
        >>> observation, info = env.reset(seed=0)
        >>> reward = 0.0
        >>> while not reward:
        ...     observation, reward, terminated, truncated, info = env.step(1)
        >>> reward, info["lives"]
        (-5.0, 4)
    """

    def __init__(self, env: Environment, reward: str) -> None:
        self._atari = require_atari(env, "ExpressionReward")
        if not isinstance(reward, str):
            raise TypeError(f"reward must be an expression such as 'reward - 5 * lives_lost', got {reward!r:.80}")
        for layer in layers(env):
            task = layer.preprocessing if isinstance(layer, EpisodeEnv) else None
            own = task is not None and (task.reward is not None or task.reward_clipping)
            if own or isinstance(layer, (gymnasium.RewardWrapper, ExpressionReward)):
                raise ValueError(
                    f"the `reward` of an expression is the game's, and {type(layer).__name__} inside ExpressionReward "
                    "changes it; put ExpressionReward inside, as atari.make(..., reward=...) does"
                )
        super().__init__(env, reward=reward)
        self._text = as_one_line(reward)
        self._formula = reward_formula(self._atari.game, self._text)
        self._inputs = np.zeros(self._formula.inputs)  # after the last step or reset

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset. The values before the first step are the values now."""
        results = self.env.reset(seed=seed, options=options)
        core = self._atari.core
        self._formula.begin(self._inputs, core.ram(), core.lives)
        return results

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Step, and pay the value of the expression."""
        self._warn_if_restored()
        observation, reward, terminated, truncated, info = self.env.step(action)
        core = self._atari.core
        paid = self._formula.pay(self._inputs, core.ram(), core.lives, float(reward))
        return observation, paid, terminated, truncated, {**info, "reward": reward}

    def _save_state(self) -> State:
        return {"inputs": self._inputs}

    def _load_state(self, state: State) -> dict[str, Any]:
        if not np.isfinite(state["inputs"]).all():
            raise ValueError("the snapshot is damaged: an input of ExpressionReward is not finite")
        return {"_inputs": state["inputs"]}

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying leave out the formula, which is compiled."""
        return {name: value for name, value in vars(self).items() if name != "_formula"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._formula = reward_formula(self._atari.game, self._text)
