"""Small changes of observations, rewards and actions, under the names of Gym's last years."""

from collections.abc import Callable, Iterable
from typing import Any

import gymnasium
import numpy as np

from atari.classic.core import ActionWrapper, Env, ObservationWrapper, RewardWrapper, Step, Wrapper
from atari.classic.spaces import Box, flatten, flatten_space
from atari.wrappers import resize_image, rgb_to_gray


class GrayScaleObservation(ObservationWrapper):
    """Images of uint8 in OpenCV's gray, (rows, columns), or (rows, columns, 1) with `keep_dim`."""

    def __init__(self, env: Env, keep_dim: bool = False) -> None:
        super().__init__(env)
        self.keep_dim = keep_dim
        rows, columns, _ = env.observation_space.shape or ()
        self.observation_space = Box(0, 255, (rows, columns, 1)[: 3 if keep_dim else 2], np.uint8)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        gray = rgb_to_gray(observation)
        return gray[..., None] if self.keep_dim else gray


class ResizeObservation(ObservationWrapper):
    """Images of uint8 in another size, (rows, columns), or one number for both; `shape` is the size."""

    def __init__(self, env: Env, shape: int | tuple[int, int]) -> None:
        super().__init__(env)
        rows_columns = (shape, shape) if isinstance(shape, int) else tuple(shape)
        if len(rows_columns) != 2 or min(rows_columns) < 1:
            raise ValueError(f"shape is (rows, columns), each 1 or more, got {shape!r}")
        self.shape = rows_columns
        old = env.observation_space.shape or ()
        self.observation_space = Box(0, 255, self.shape + tuple(old[2:]), np.uint8)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return resize_image(observation, self.shape)


class FlattenObservation(ObservationWrapper):
    """Observations as one array of numbers."""

    def __init__(self, env: Env) -> None:
        super().__init__(env)
        self.observation_space = flatten_space(env.observation_space)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return flatten(self.env.observation_space, observation)


class FlattenDictWrapper(ObservationWrapper):
    """The parts `dict_keys` of a dictionary, as one array of numbers."""

    def __init__(self, env: Env, dict_keys: Iterable[str]) -> None:
        super().__init__(env)
        self.dict_keys = list(dict_keys)
        parts: Any = env.observation_space
        size = sum(int(np.prod(parts[key].shape)) for key in self.dict_keys)
        self.observation_space = Box(-np.inf, np.inf, (size,), np.float32)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return np.concatenate([np.ravel(observation[key]) for key in self.dict_keys])


class ClipAction(ActionWrapper):
    """Actions beyond the bounds of a Box are clipped to the bounds."""

    def action(self, action: Any) -> Any:
        """The action to take instead."""
        bounds: Any = self.action_space
        return np.clip(action, bounds.low, bounds.high)


class RescaleAction(ActionWrapper):
    """Actions within `min_action` to `max_action`, stretched to the bounds of the environment.

    Their names until 2021 were `a` and `b`.

    Raises:
        TypeError: the actions are no Box, or a bound is missing.
        ValueError: `min_action` is greater than `max_action`.
    """

    def __init__(
        self, env: Env, min_action: Any = None, max_action: Any = None, *, a: Any = None, b: Any = None
    ) -> None:
        super().__init__(env)
        space = env.action_space
        low, high = a if min_action is None else min_action, b if max_action is None else max_action
        if not isinstance(space, gymnasium.spaces.Box) or low is None or high is None:
            raise TypeError(f"RescaleAction takes a Box of actions and its new bounds, got {space}, {low} and {high}")
        self.min_action = self.a = np.broadcast_to(np.asarray(low, space.dtype), space.shape)
        self.max_action = self.b = np.broadcast_to(np.asarray(high, space.dtype), space.shape)
        if (self.min_action > self.max_action).any():
            raise ValueError(f"min_action is at most max_action, got {low} and {high}")
        self.action_space = Box(self.min_action, self.max_action, dtype=space.dtype)

    def action(self, action: Any) -> Any:
        """The action to take instead."""
        space: Any = self.env.action_space
        share = (np.asarray(action) - self.min_action) / (self.max_action - self.min_action)
        return np.clip(space.low + (space.high - space.low) * share, space.low, space.high)


class TransformObservation(ObservationWrapper):
    """Observations are mapped by `f`."""

    def __init__(self, env: Env, f: Callable[[Any], Any]) -> None:
        super().__init__(env)
        self.f = f

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return self.f(observation)


class TransformReward(RewardWrapper):
    """Rewards are mapped by `f`."""

    def __init__(self, env: Env, f: Callable[[Any], Any]) -> None:
        super().__init__(env)
        self.f = f

    def reward(self, reward: Any) -> Any:
        """The reward to return instead."""
        return self.f(reward)


def SkipWrapper(repeat_count: int) -> type[Wrapper]:
    """A wrapper class whose environments take each action `repeat_count` times more.

    `info["skip.stepcount"]` is the number of steps in the episode.
    """

    class SkipWrapper(Wrapper):
        """Takes each action several times and returns the sum of the rewards; `stepcount` counts the steps."""

        def __init__(self, env: Env) -> None:
            super().__init__(env)
            self.repeat_count = repeat_count
            self.stepcount = 0

        def _step(self, action: Any) -> Step:
            total = 0.0
            for _ in range(self.repeat_count + 1):
                self.stepcount += 1
                observation, reward, done, info = self.env.step(action)
                total += reward
                if done:
                    break
            return observation, total, done, {**info, "skip.stepcount": self.stepcount}

        def _reset(self, **options: Any) -> Any:
            self.stepcount = 0
            return self.env.reset(**options)

    return SkipWrapper
