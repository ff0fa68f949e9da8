"""Small changes of observations, rewards and actions, under the names of Gym's last years."""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np
from gymnasium import wrappers

from atari.classic.core import ActionWrapper, Env, ObservationWrapper, RewardWrapper, Step, Wrapper
from atari.classic.spaces import Box
from atari.classic.wrappers.bridge import Bridge


class GrayScaleObservation(ObservationWrapper):
    """Images in OpenCV's gray, (rows, columns), or (rows, columns, 1) with `keep_dim`."""

    def __init__(self, env: Env, keep_dim: bool = False) -> None:
        import cv2  # imported here because the import is slow

        super().__init__(env)
        self._keep_dim = keep_dim
        self._to_gray = partial(cv2.cvtColor, code=cv2.COLOR_RGB2GRAY)
        rows, columns, _ = env.observation_space.shape or ()
        self.observation_space = Box(0, 255, (rows, columns, 1)[: 3 if keep_dim else 2], np.uint8)

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        gray = self._to_gray(observation)
        return gray[..., None] if self._keep_dim else gray


class ResizeObservation(Bridge):
    """Images in another size, (rows, columns), or one number for both."""

    def __init__(self, env: Env, shape: int | tuple[int, int]) -> None:
        size = (shape, shape) if isinstance(shape, int) else shape
        super().__init__(env, lambda inside: wrappers.ResizeObservation(inside, size))

    def _reset(self, **options: Any) -> Any:
        return self._shaped(super()._reset(**options))

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = super()._step(action)
        return self._shaped(observation), reward, done, info

    def _shaped(self, observation: Any) -> Any:
        """The image with its axis of one colour, which OpenCV drops and Gymnasium 1.1 does not restore."""
        return observation.reshape(self.observation_space.shape)


class FlattenObservation(Bridge):
    """Observations as one array of numbers."""

    def __init__(self, env: Env) -> None:
        super().__init__(env, wrappers.FlattenObservation)


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


class RescaleAction(Bridge):
    """Actions within `a` to `b`, stretched to the bounds of the environment."""

    def __init__(self, env: Env, a: Any, b: Any) -> None:
        super().__init__(env, lambda inside: wrappers.RescaleAction(inside, a, b))


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
