"""`Checked`: clear errors for the common mistakes in users' environments."""

from typing import Any

import gymnasium
import numpy as np

from atari.classic.adapter import to_action
from atari.classic.core import Env, Step, Wrapper


class Checked(Wrapper):
    """Checks the actions and results of an old-style environment; `make` wraps users' environments in it.

    `step` raises:
        gymnasium.error.ResetNeeded: before the first reset.
        TypeError: the environment did not return observation, reward, done and info.
        TypeError, ValueError: the action is not in the action space; the bounds of a Box are not checked.
    """

    def __init__(self, env: Env) -> None:
        for name in ("action_space", "observation_space"):
            if not isinstance(getattr(env, name, None), gymnasium.Space):
                raise TypeError(f"{type(env).__name__} has no {name}; set self.{name} to a space in its __init__")
        super().__init__(env)
        self._started = False

    def _reset(self, **options: Any) -> Any:
        observation = self.env.reset(**options)
        name = type(self.unwrapped).__name__
        if observation is None:
            raise TypeError(f"{name}.reset() returned nothing; it must return the first observation")
        if _is_pair(observation) and not self.observation_space.contains(observation):
            raise TypeError(
                f"{name}.reset() returned (observation, info), as in Gymnasium; here it must return the observation "
                "alone (or derive the class from gymnasium.Env)"
            )
        self._started = True
        return observation

    def _step(self, action: Any) -> Step:
        if not self._started:
            raise gymnasium.error.ResetNeeded("step() came before the first reset(); call env.reset() first")
        return check_step(self.env.step(to_action(self.action_space, action)), type(self.unwrapped).__name__)


def check_step(result: Any, name: str) -> Step:
    """The result of `step`, checked.

    Raises:
        TypeError: it is not observation, reward, done and info; the message says how to fix it.
    """
    wanted = f"{name}.step() must return observation, reward, done, info"
    if not isinstance(result, tuple):
        raise TypeError(f"{wanted}, but returned {'nothing' if result is None else f'a {type(result).__name__}'}")
    if len(result) == 5:
        raise TypeError(
            f"{wanted}, but returned five values, as in Gymnasium; return `terminated or truncated` as done "
            "(or derive the class from gymnasium.Env)"
        )
    if len(result) != 4:
        raise TypeError(f"{wanted}, but returned {len(result)} values")
    observation, reward, done, info = result
    if not isinstance(done, (bool, np.bool_)) and done not in (0, 1):
        raise TypeError(f"{wanted}, but done is {done!r}; it must be True or False")
    if not isinstance(info, dict):
        raise TypeError(f"{wanted}, but info is {info!r}; return {{}} if there is nothing to say")
    return observation, reward, bool(done), info


def _is_pair(value: Any) -> bool:
    return isinstance(value, tuple) and len(value) == 2 and isinstance(value[1], dict)
