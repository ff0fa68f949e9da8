"""Observations and rewards, normalised by the mean and variance of all so far."""

from typing import Any

import numpy as np
from gymnasium import wrappers

from atari.classic.core import Env, Step, Wrapper

__all__ = ["NormalizeObservation", "NormalizeReward", "RunningMeanStd", "update_mean_var_count_from_moments"]

_moments: Any = getattr(wrappers, "normalize", None) or wrappers.utils  # their module before Gymnasium 1.0
RunningMeanStd = _moments.RunningMeanStd
update_mean_var_count_from_moments = _moments.update_mean_var_count_from_moments


class NormalizeObservation(Wrapper):
    """Observations minus their mean, divided by their standard deviation, over all observations so far.

    Args:
        env: an environment with arrays as observations, or a vector of them.
        epsilon: added to the variance.

    Attributes:
        obs_rms: the moments, a `RunningMeanStd`.

    Example:
        >>> import atari.classic as gym
        >>> env = gym.wrappers.NormalizeObservation(gym.make("CartPole-v1"))
        >>> env.reset().shape, round(env.obs_rms.count, 2)
        ((4,), 1.0)
    """

    def __init__(self, env: Env, epsilon: float = 1e-8) -> None:
        super().__init__(env)
        self.num_envs: int = getattr(env, "num_envs", 1)
        self.is_vector_env: bool = getattr(env, "is_vector_env", False)
        space: Any = env.single_observation_space if self.is_vector_env else env.observation_space  # type: ignore[attr-defined]
        self.obs_rms = RunningMeanStd(shape=space.shape)
        self.epsilon = epsilon

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        return self._normalised(observation), reward, done, info

    def _reset(self, **options: Any) -> Any:
        return self._normalised(self.env.reset(**options))

    def normalize(self, obs: Any) -> Any:
        """A batch of observations, normalised, after it counted for the moments."""
        self.obs_rms.update(obs)
        return (obs - self.obs_rms.mean) / np.sqrt(self.obs_rms.var + self.epsilon)

    def _normalised(self, observation: Any) -> Any:
        return self.normalize(observation) if self.is_vector_env else self.normalize(np.array([observation]))[0]


class NormalizeReward(Wrapper):
    """Rewards divided by the standard deviation of discounted returns, over all steps so far.

    Args:
        env: an environment, or a vector of them.
        gamma: the discount of the returns.
        epsilon: added to the variance.

    Attributes:
        return_rms: the moments of the returns, a `RunningMeanStd`.
        returns: the discounted sum of the rewards of each environment's episode, (num_envs,).
    """

    def __init__(self, env: Env, gamma: float = 0.99, epsilon: float = 1e-8) -> None:
        super().__init__(env)
        self.num_envs: int = getattr(env, "num_envs", 1)
        self.is_vector_env: bool = getattr(env, "is_vector_env", False)
        self.return_rms = RunningMeanStd(shape=())
        self.returns = np.zeros(self.num_envs)
        self.gamma = gamma
        self.epsilon = epsilon

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        rewards = np.asarray(reward) if self.is_vector_env else np.array([reward])
        self.returns = self.returns * self.gamma + rewards
        rewards = self.normalize(rewards)
        self.returns[np.atleast_1d(done).astype(np.bool_)] = 0.0
        return observation, rewards if self.is_vector_env else rewards[0], done, info

    def normalize(self, rews: Any) -> Any:
        """Rewards, normalised, after the present returns counted for the moments."""
        self.return_rms.update(self.returns)
        return rews / np.sqrt(self.return_rms.var + self.epsilon)
