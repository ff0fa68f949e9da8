"""`VectorEnv`: several environments that step together."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array

from atari.classic.core import Env
from atari.classic.spaces import Space, Tuple, from_gymnasium

WrapMany = Callable[[Env], Env] | Iterable[Callable[[Env], Env]]

Results = tuple[Any, Any, Any, list[dict[str, Any]]]
"""Observations, rewards (num_envs,) float64, whether episodes are over (num_envs,) bool, and the infos."""


class VectorEnv(Env):
    """Several environments with equal spaces; each begins a new episode by itself.

    `step` returns the first observation of the new episode; `info["terminal_observation"]` is the last of the old one.
    A subclass defines `_reset_all`, `_step_all`, `_call_all` and `_seed_all`.

    Args:
        num_envs: their number.
        observation_space: the space of one environment's observations.
        action_space: the space of one environment's actions.
    """

    is_vector_env = True

    def __init__(self, num_envs: int, observation_space: Space[Any], action_space: Space[Any]) -> None:
        self.num_envs = num_envs
        self.single_observation_space = observation_space
        self.single_action_space = action_space
        self.observation_space = from_gymnasium(batch_space(observation_space, num_envs))
        self.action_space = Tuple([action_space] * num_envs)
        self.closed = False
        self._actions: list[Any] | None = None

    def reset(self, **options: Any) -> Any:
        """Begin an episode in each environment, and return the observations."""
        self._actions = None
        return self._batch(self._reset_all(options))

    def step_async(self, actions: Any) -> None:
        """Take the actions for the next `step_wait`.

        Raises:
            ValueError: their number is not that of the environments.
        """
        actions = list(actions)
        if len(actions) != self.num_envs:
            raise ValueError(f"there are {self.num_envs} environments, got {len(actions)} actions")
        self._actions = actions

    def step_wait(self) -> Results:
        """Step with the actions of `step_async`.

        Raises:
            gymnasium.error.Error: there are no actions.
        """
        actions, self._actions = self._actions, None
        if actions is None:
            raise gymnasium.error.Error("step_wait() came before step_async(actions); call it first, or step(actions)")
        observations, rewards, dones, infos = zip(*self._step_all(actions), strict=True)
        return self._batch(observations), np.array(rewards, np.float64), np.array(dones, np.bool_), list(infos)

    def step(self, action: Any) -> Any:
        """Take an action in each environment."""
        self.step_async(action)
        return self.step_wait()

    def seed(self, seed: int | Sequence[int | None] | None = None) -> list[Any]:
        """Seed the environments: with the seeds of a list, or with `seed`, `seed + 1`, ...

        Raises:
            ValueError: the number of seeds is not that of the environments.
        """
        seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, (int, np.integer)) else seed
        seeds = [None] * self.num_envs if seeds is None else list(seeds)
        if len(seeds) != self.num_envs:
            raise ValueError(f"there are {self.num_envs} environments, got {len(seeds)} seeds")
        return self._seed_all(seeds)

    def call(self, name: str, *arguments: Any, **options: Any) -> list[Any]:
        """The results of a method of each environment, or the values of an attribute."""
        return self._call_all(name, arguments, options)

    def get_attr(self, name: str) -> list[Any]:
        """The values of an attribute."""
        return self.call(name)

    def _reset_all(self, options: dict[str, Any]) -> Sequence[Any]:
        raise NotImplementedError

    def _step_all(self, actions: Sequence[Any]) -> Sequence[Any]:
        raise NotImplementedError

    def _call_all(self, name: str, arguments: Sequence[Any], options: dict[str, Any]) -> list[Any]:
        raise NotImplementedError

    def _seed_all(self, seeds: Sequence[int | None]) -> list[Any]:
        raise NotImplementedError

    def _batch(self, observations: Iterable[Any]) -> Any:
        space = self.single_observation_space
        empty: Any = create_empty_array(space, self.num_envs)
        return concatenate(space, list(observations), empty)


class Lane:
    """One environment of a vector, which begins a new episode by itself."""

    def __init__(self, env: Env) -> None:
        self.env = env

    def reset(self, options: dict[str, Any]) -> Any:
        """Begin an episode."""
        return self.env.reset(**options)

    def step(self, action: Any) -> tuple[Any, Any, bool, dict[str, Any]]:
        """Take an action; after the end of an episode, the observation is the first of the next."""
        observation, reward, done, info = self.env.step(action)
        if done:
            info["terminal_observation"] = observation
            observation = self.env.reset()
        return observation, reward, done, info

    def call(self, name: str, arguments: Sequence[Any], options: dict[str, Any]) -> Any:
        """The result of a method, or the value of an attribute."""
        value = getattr(self.env, name)
        return value(*arguments, **options) if callable(value) else value

    def seed(self, seed: int | None) -> list[int]:
        """Seed the environment."""
        return self.env.seed(seed)

    def close(self) -> None:
        """Close the environment."""
        self.env.close()


def check_env_fns(env_fns: Iterable[Callable[[], Env]]) -> list[Callable[[], Env]]:
    """The functions that make the environments, as a list.

    Raises:
        ValueError: there are none.
    """
    functions = list(env_fns)
    if not functions:
        raise ValueError("a vector has one environment or more, got no function that makes one")
    return functions
