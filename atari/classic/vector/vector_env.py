"""`VectorEnv`: several environments that step together."""

import copy
import functools
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from atari.classic import error
from atari.classic.core import Env, Wrapper
from atari.classic.spaces import Space, Tuple
from atari.classic.vector.utils import batch_space, concatenate, create_empty_array

WrapMany = Callable[[Env], Env] | Iterable[Callable[[Env], Env]]

Results = tuple[Any, Any, Any, list[dict[str, Any]]]
"""Observations, rewards (num_envs,) float64, whether episodes are over (num_envs,) bool, and the infos."""


class VectorEnv(Env):
    """Several environments with equal spaces; each begins a new episode by itself.

    `step` returns the first observation of the new episode; `info["terminal_observation"]` is the last of the old one.
    `reset`, `step` and `call` begin with `reset_async`, `step_async` or `call_async` and return what `reset_wait`,
    `step_wait` or `call_wait` returns. A subclass defines these, and `close_extras`.

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
        self.observation_space = batch_space(observation_space, num_envs)
        self.action_space = Tuple([action_space] * num_envs)
        self.closed = False
        self.viewer: Any = None

    def reset_async(self, **options: Any) -> None:
        """Begin to reset the environments, for the next `reset_wait`."""

    def reset_wait(self, **kwargs: Any) -> Any:
        """The first observations, after `reset_async`."""
        raise NotImplementedError(f"{type(self).__name__} has no reset_wait(); define it")

    def reset(self, **options: Any) -> Any:
        """Begin an episode in each environment, and return the observations."""
        self.reset_async(**options)
        return self.reset_wait()

    def step_async(self, actions: Any) -> None:
        """Take the actions for the next `step_wait`."""

    def step_wait(self, **kwargs: Any) -> Results:
        """The results of a step, after `step_async`."""
        raise NotImplementedError(f"{type(self).__name__} has no step_wait(); define it")

    def step(self, actions: Any) -> Any:
        """Take an action in each environment.

        Raises:
            ValueError: the number of actions is not that of the environments.
        """
        self.step_async(actions)
        return self.step_wait()

    def call_async(self, name: str, *args: Any, **kwargs: Any) -> None:
        """Begin to call a method of each environment, for the next `call_wait`."""

    def call_wait(self, **kwargs: Any) -> list[Any]:
        """The results of the methods, after `call_async`."""
        raise NotImplementedError(f"{type(self).__name__} has no call_wait(); define it")

    def call(self, name: str, *args: Any, **kwargs: Any) -> list[Any]:
        """The results of a method of each environment, or the values of an attribute."""
        self.call_async(name, *args, **kwargs)
        return self.call_wait()

    def get_attr(self, name: str) -> list[Any]:
        """The values of an attribute."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each environment: to one of a list or tuple, or all to one value.

        Raises:
            ValueError: the number of values is not that of the environments.
        """
        raise NotImplementedError(f"{type(self).__name__} has no set_attr(); define it")

    def seed(self, seeds: Any = None, *, seed: Any = None) -> list[Any]:  # type: ignore[override]
        """Seed the environments: with the seeds of a list, or with `seeds`, `seeds + 1`, ...; `seed` means the same.

        Raises:
            ValueError: the number of seeds is not that of the environments.
        """
        return []

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments."""

    def _add_info(self, infos: dict[str, Any], info: dict[str, Any], env_num: int) -> dict[str, Any]:
        """Add the info of an environment to a dictionary of arrays, with masks under names with an underscore.

        Vectors here have a list of infos. A subclass may call this to have one dictionary, as in Gym 0.26.
        """
        for key, value in info.items():
            if key not in infos:
                infos[key], infos[f"_{key}"] = self._init_info_arrays(type(value))
            infos[key][env_num], infos[f"_{key}"][env_num] = value, True
        return infos

    def _init_info_arrays(self, dtype: type) -> tuple[Any, Any]:
        """An array for the values of all environments, of the dtype of numbers or else of objects, and its mask."""
        is_number = dtype in (int, float, bool) or issubclass(dtype, np.number)
        values = np.zeros(self.num_envs, dtype) if is_number else np.full(self.num_envs, None, object)
        return values, np.zeros(self.num_envs, np.bool_)

    def close(self, **kwargs: Any) -> None:
        """Close the environments; later calls do nothing. `kwargs` are arguments of `close_extras`."""
        if self.closed:
            return
        self.closed = True
        if self.viewer is not None:
            self.viewer.close()
        self.close_extras(**kwargs)

    def __del__(self) -> None:
        if not vars(self).get("closed", True):
            with suppress(Exception):  # a finalizer has no caller
                self.close()

    def __str__(self) -> str:
        return f"{type(self).__name__}({f'{self.spec.id}, ' if self.spec else ''}{self.num_envs})"

    __repr__ = __str__


class Batches(VectorEnv):
    """The parts that vectors in one process and in several share: batches, and checks of numbers."""

    def __init__(
        self, num_envs: int, observation_space: Space[Any], action_space: Space[Any], is_copied: bool = True
    ) -> None:
        super().__init__(num_envs, observation_space, action_space)
        self.copy = is_copied
        self.observations: Any = create_empty_array(observation_space, num_envs)

    def _batch(self, observations: Iterable[Any]) -> Any:
        items = list(observations)
        self.observations = concatenate(items, self.observations, self.single_observation_space)
        return copy.deepcopy(self.observations) if self.copy else self.observations

    def _results(self, results: Iterable[Any]) -> Results:
        observations, rewards, dones, infos = zip(*results, strict=True)
        return self._batch(observations), np.array(rewards, np.float64), np.array(dones, np.bool_), list(infos)

    def _one_each(self, given: Iterable[Any], what: str) -> list[Any]:
        each = list(given)
        if len(each) != self.num_envs:
            raise ValueError(f"there are {self.num_envs} environments, got {len(each)} {what}")
        return each

    def _checked_values(self, values: Any) -> list[Any]:
        return self._one_each(values if isinstance(values, (list, tuple)) else [values] * self.num_envs, "values")

    def _checked_seeds(self, seeds: int | Sequence[int | None] | None, seed: Any) -> list[int | None]:
        chosen = seed if seeds is None else seeds
        if isinstance(chosen, (int, np.integer)):
            return [int(chosen) + i for i in range(self.num_envs)]
        return self._one_each([None] * self.num_envs if chosen is None else chosen, "seeds")

    def _check_spaces(self) -> bool:
        """Check that the observations of all environments fit into the batch."""
        return self._check_observation_spaces()

    def _check_observation_spaces(self) -> bool:
        raise NotImplementedError

    def _check_fit(self, spaces: Iterable[Space[Any]]) -> bool:
        for space in spaces:
            if space.shape != self.single_observation_space.shape:
                raise RuntimeError(
                    f"a vector needs observations of one shape, got {space} beside {self.single_observation_space}"
                )
        return True


class VectorEnvWrapper(VectorEnv, Wrapper):
    """A vector around another one, `env`, whose methods and attributes it has unless it defines its own.

    Raises:
        TypeError: `env` is no `VectorEnv`.

    Example:
        >>> import atari.classic as gym
        >>> class Halved(gym.vector.VectorEnvWrapper):
        ...     def step_wait(self):
        ...         observations, rewards, dones, infos = self.env.step_wait()
        ...         return observations, rewards / 2, dones, infos
        >>> envs = Halved(gym.vector.make("CartPole-v1", 2, asynchronous=False))
        >>> envs.reset().shape, envs.step([0, 1])[1].tolist()
        ((2, 4), [0.5, 0.5])
    """

    def __init__(self, env: VectorEnv) -> None:
        if not isinstance(env, VectorEnv):
            raise TypeError(f"a VectorEnvWrapper goes around a vector, such as gym.vector.make(...), got {env!r}")
        Wrapper.__init__(self, env)
        self.env: Any = env

    def seed(self, seeds: Any = None, *, seed: Any = None) -> list[Any]:  # type: ignore[override]  # noqa: D102
        return self.env.seed(seed if seeds is None else seeds)

    @property
    def unwrapped(self) -> Env:  # noqa: D102
        return self.env.unwrapped

    def render(self, *args: Any, **options: Any) -> Any:  # noqa: D102
        return self.env.render(*args, **options)

    def __del__(self) -> None:
        """The vector inside closes itself."""

    def __str__(self) -> str:
        return f"<{type(self).__name__}, {self.env}>"

    __repr__ = __str__


def _of_inner(name: str) -> Callable[..., Any]:
    """The method of a wrapper that calls that of the vector inside."""

    @functools.wraps(getattr(VectorEnv, name))
    def method(self: VectorEnvWrapper, *arguments: Any, **options: Any) -> Any:
        return getattr(self.env, name)(*arguments, **options)

    return method


for _name in ("reset", "step", "call"):
    for _part in ("_async", "_wait"):
        setattr(VectorEnvWrapper, _name + _part, _of_inner(_name + _part))
for _name in ("call", "set_attr", "close", "close_extras"):
    setattr(VectorEnvWrapper, _name, _of_inner(_name))


def step_and_reset(env: Env, action: Any) -> tuple[Any, Any, bool, dict[str, Any]]:
    """Take an action; after the end of an episode, the observation is the first of the next."""
    observation, reward, done, info = env.step(action)
    if done:
        info["terminal_observation"] = observation
        observation = env.reset()
    return observation, reward, done, info


def call(env: Env, name: str, arguments: Sequence[Any], options: dict[str, Any]) -> Any:
    """The result of a method, or the value of an attribute."""
    value = getattr(env, name)
    return value(*arguments, **options) if callable(value) else value


class NoCallError(error.Error, error.NoAsyncCallError):
    """A result was requested before it was begun; `name` is the method that begins it."""


class PendingCallError(error.Error, error.AlreadyPendingCallError):
    """Another result is pending; `name` is its method."""


class ClosedError(error.Error, error.ClosedEnvironmentError):
    """The vector is closed, or one of its processes has ended."""


def check_env_fns(env_fns: Iterable[Callable[[], Env]]) -> list[Callable[[], Env]]:
    """The functions that make the environments, as a list.

    Raises:
        ValueError: there are none.
    """
    functions = list(env_fns)
    if not functions:
        raise ValueError("a vector has one environment or more, got no function that makes one")
    return functions
