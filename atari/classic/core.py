"""The environment of OpenAI Gym's first years, and wrappers around it.

The interface is that of the paper (Brockman et al. 2016, "OpenAI Gym"). `reset` returns an observation. `step` returns
an observation, a reward, whether the episode is over, and a dictionary. `render` has the mode as an argument; `seed`
is a method. The methods of an environment may begin with an underscore (`_step`), as before 2018.
"""

from functools import cached_property
from types import TracebackType
from typing import Any

from gymnasium.core import ActType, ObsType, RenderFrame

from atari.classic.monitor_hooks import EnvMonitor
from atari.classic.spaces import Space
from atari.classic.spec import Spec
from atari.classic.utils import seeding

__all__ = [
    "ActType",
    "ActionWrapper",
    "Env",
    "GoalEnv",
    "ObsType",
    "ObservationWrapper",
    "RenderFrame",
    "RewardWrapper",
    "Space",
    "Step",
    "Wrapper",
]

Step = tuple[Any, Any, bool, dict[str, Any]]
"""The result of `step`: observation, reward, done, info."""


class Env:
    """An environment.

    Subclass it, set `action_space` and `observation_space`, define `reset` and `step`, and optionally `render`,
    `seed` and `close`.

    Example:
        >>> import atari.classic as gym
        >>> class Coin(gym.Env):
        ...     action_space = gym.spaces.Discrete(2)
        ...     observation_space = gym.spaces.Discrete(2)
        ...     def reset(self):
        ...         return 0
        ...     def step(self, action):
        ...         return 0, float(action), True, {}
        >>> env = Coin()
        >>> env.reset(), env.step(1)
        (0, (0, 1.0, True, {}))
    """

    metadata: dict[str, Any] = {"render.modes": []}  # noqa: RUF012
    """"render.modes" lists the modes of `render`, from "human", "rgb_array" and "ansi"."""

    reward_range: tuple[float, float] = (-float("inf"), float("inf"))
    spec: Spec | None = None
    """The ID and limits with which `make` made the environment; None without `make`."""

    render_mode: str | None = None
    """None: the mode is an argument of `render`."""

    action_space: Space[Any]
    observation_space: Space[Any]

    def __init_subclass__(cls, **options: Any) -> None:
        """Let a method under its name of before 2018, such as `_step`, replace an inherited `step`.

        The methods of this module call it already.
        """
        super().__init_subclass__(**options)
        for name in ("step", "reset", "render", "seed", "close"):
            old = callable(vars(cls).get(f"_{name}")) and name not in vars(cls)
            if old and getattr(cls, name).__module__ != __name__:
                homes = (base for base in cls.__mro__ if base.__module__ == __name__ and name in vars(base))
                setattr(cls, name, vars(next(homes))[name])

    def step(self, action: Any) -> Step:
        """Take an action; return the observation, the reward, whether the episode is over, and diagnostics."""
        return self._call("step", action)

    def reset(self) -> Any:
        """Start a new episode and return its first observation."""
        return self._call("reset")

    def render(self, mode: str = "human", **options: Any) -> Any:
        """Show the environment ("human"), or return it as (rows, columns, 3) uint8 ("rgb_array") or text ("ansi")."""
        return self._call("render", mode, **options)

    def close(self) -> None:
        """Release the environment's resources."""
        if callable(getattr(self, "_close", None)):
            self._call("close")

    def seed(self, seed: int | None = None) -> list[int]:
        """Seed the random generators and return the seeds; an environment without any returns none."""
        return list(self._call("seed", seed) or []) if callable(getattr(self, "_seed", None)) else []

    @property
    def np_random(self) -> Any:
        """A generator, NumPy's `RandomState`; an environment may assign another one."""
        if "_np_random" not in vars(self):
            self._np_random: Any = seeding.np_random()[0]
        return self._np_random

    @np_random.setter
    def np_random(self, generator: Any) -> None:
        self._np_random = generator

    @property
    def unwrapped(self) -> "Env":
        """The environment inside all wrappers."""
        return self

    @cached_property
    def monitor(self) -> Any:
        """Records videos and statistics between its `start` and `close`, as in 2016."""
        return EnvMonitor(self)

    def _call(self, name: str, *args: Any, **options: Any) -> Any:
        """Call the method under its name of before 2018."""
        old = getattr(self, f"_{name}", None)
        if not callable(old):
            raise NotImplementedError(f"{type(self).__name__} has no {name}(); define it")
        return old(*args, **options)

    def __str__(self) -> str:
        return f"<{type(self).__name__}{f'<{self.spec.id}>' if self.spec else ' instance'}>"

    def __enter__(self) -> "Env":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class GoalEnv(Env):
    """An environment with goals: observations are dictionaries of observation, achieved_goal and desired_goal.

    `compute_reward` returns the reward that a step would have had with another goal (Andrychowicz et al. 2017,
    "Hindsight Experience Replay").

    Example:
        >>> import atari.classic as gym
        >>> issubclass(gym.GoalEnv, gym.Env)
        True
    """

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: dict[str, Any]) -> Any:
        """The reward for an achieved goal when another one was desired.

        Raises:
            NotImplementedError: the environment does not define it.
        """
        raise NotImplementedError(f"{type(self).__name__} has no compute_reward(); define it")


class Wrapper(Env):
    """An environment around another, `env`, whose methods and attributes it has unless it defines its own.

    Raises:
        TypeError: `env` is not an `Env` of this interface.

    Example:
        >>> import atari.classic as gym
        >>> env = gym.Wrapper(gym.make("CartPole-v0"))
        >>> env.reset().shape
        (4,)
    """

    def __init__(self, env: Env) -> None:
        if not isinstance(env, Env):
            raise TypeError(f"a wrapper of atari.classic goes around one of its environments, got {env!r}; make() one")
        self.env = env
        self.action_space = env.action_space
        self.observation_space = env.observation_space
        self.reward_range = env.reward_range
        self.metadata = env.metadata
        self.spec = env.spec

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        return getattr(self.env, name)

    @classmethod
    def class_name(cls) -> str:
        """The name of the wrapper."""
        return cls.__name__

    @property
    def np_random(self) -> Any:
        """The generator of the environment."""
        return self.env.np_random

    @np_random.setter
    def np_random(self, generator: Any) -> None:
        self.env.np_random = generator

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: dict[str, Any]) -> Any:
        """See `GoalEnv`."""
        return self.env.compute_reward(achieved_goal, desired_goal, info)  # type: ignore[attr-defined]

    def reset(self, **options: Any) -> Any:  # noqa: D102
        return self._call("reset", **options)

    def render(self, *args: Any, **options: Any) -> Any:  # noqa: D102 - an environment's render() may lack a mode
        return self._call("render", *args, **options)

    # With underscores, so that a subclass may define either `step` or, as before 2018, `_step`.

    def _step(self, action: Any) -> Step:
        return self.env.step(action)

    def _reset(self, **options: Any) -> Any:
        return self.env.reset(**options)

    def _render(self, *args: Any, **options: Any) -> Any:
        return self.env.render(*args, **options)

    def _close(self) -> None:
        self.env.close()

    def _seed(self, seed: int | None = None) -> list[int]:
        return self.env.seed(seed)

    @property
    def unwrapped(self) -> Env:  # noqa: D102
        return self.env.unwrapped

    def __str__(self) -> str:
        return f"<{type(self).__name__}{self.env}>"


class ObservationWrapper(Wrapper):
    """A wrapper that changes observations; define `observation`.

    Example:
        >>> import atari.classic as gym
        >>> class Doubled(gym.ObservationWrapper):
        ...     def observation(self, observation):
        ...         return 2 * observation
        >>> Doubled(gym.make("CartPole-v0")).reset().shape
        (4,)
    """

    def _reset(self, **options: Any) -> Any:
        return self.observation(self.env.reset(**options))

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        return self.observation(observation), reward, done, info

    def observation(self, observation: Any) -> Any:
        """The observation to return instead."""
        return self._call("observation", observation)


class RewardWrapper(Wrapper):
    """A wrapper that changes rewards; define `reward`.

    Example:
        >>> import atari.classic as gym
        >>> class Scaled(gym.RewardWrapper):
        ...     def reward(self, reward):
        ...         return reward / 10
        >>> env = Scaled(gym.make("CartPole-v0"))
        >>> env.reset().shape
        (4,)
        >>> env.step(0)[1]
        0.1
    """

    def _step(self, action: Any) -> Step:
        observation, reward, done, info = self.env.step(action)
        return observation, self.reward(reward), done, info

    def reward(self, reward: Any) -> Any:
        """The reward to return instead."""
        return self._call("reward", reward)


class ActionWrapper(Wrapper):
    """A wrapper that changes actions; define `action`.

    Example:
        >>> import atari.classic as gym
        >>> class Mirrored(gym.ActionWrapper):
        ...     def action(self, action):
        ...         return 1 - action
        >>> env = Mirrored(gym.make("CartPole-v0"))
        >>> env.reset().shape
        (4,)
        >>> env.step(0)[2]
        False
    """

    def _step(self, action: Any) -> Step:
        return self.env.step(self.action(action))

    def action(self, action: Any) -> Any:
        """The action to take instead."""
        return self._call("action", action)

    def reverse_action(self, action: Any) -> Any:
        """The action that `action` maps to this one."""
        return self._call("reverse_action", action)
