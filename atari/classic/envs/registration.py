"""Gym's registry, as another interface to Gymnasium's.

Only Gymnasium's registry has entries, so both interfaces can make each registered environment. An `EnvSpec` has the
fields of Gym's specs; each lookup derives it from Gymnasium's spec, with Gym's limits for Atari games.
"""

import copy
import dataclasses
import re
from collections.abc import Callable, Iterator, MutableMapping, ValuesView
from typing import Any

import gymnasium
from gymnasium.envs.registration import EnvSpec as ModernSpec
from gymnasium.envs.registration import load_env_creator

from atari.classic import history, lookup
from atari.classic.adapter import Adapter, adapt, quiet_options
from atari.classic.checks import Checked
from atari.classic.core import Env
from atari.classic.envs.atari.atari_env import modern_options, old_options
from atari.classic.modern import EntryPoint
from atari.classic.spec import Spec
from atari.classic.wrappers.time_limit import TimeLimit

_ID = re.compile(r"(?:[\w-]+/)?[\w:.-]+-v(\d+)")


class EnvSpec(Spec):
    """An entry of the registry, which can make its environment."""

    def make(self, **options: Any) -> Env:
        """Make the environment."""
        return make(self.id, **options)


class EnvSpecs(MutableMapping[str, EnvSpec]):
    """All specs by ID; after deleting one, its ID can be registered again."""

    def __getitem__(self, env_id: str) -> EnvSpec:
        if not lookup.is_alive(env_id):
            raise KeyError(env_id)
        return _classic_spec(gymnasium.registry[env_id])

    def __setitem__(self, env_id: str, spec: EnvSpec) -> None:
        entry_point = spec.entry_point
        gymnasium.registry[env_id] = ModernSpec(
            id=env_id,
            entry_point=entry_point if entry_point is None else EntryPoint(entry_point),
            reward_threshold=spec.reward_threshold,
            nondeterministic=spec.nondeterministic,
            max_episode_steps=spec.max_episode_steps,
            kwargs=spec.kwargs,
        )

    def __delitem__(self, env_id: str) -> None:
        del gymnasium.registry[env_id]

    def __iter__(self) -> Iterator[str]:
        lookup.load_robotics()
        return iter([env_id for env_id in gymnasium.registry if lookup.is_alive(env_id)])

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return repr(dict(self))


class EnvRegistry:
    """The registry as an object: `registry.all()`, `registry.env_specs`, `registry.spec(id)`, `registry.make(id)`."""

    def __init__(self) -> None:
        self.env_specs = EnvSpecs()

    def all(self) -> ValuesView[EnvSpec]:
        """Every `EnvSpec`."""
        return dict(self.env_specs).values()

    def spec(self, id: str) -> EnvSpec:
        """See `spec`."""
        return spec(id)

    def make(self, id: str, **options: Any) -> Env:
        """See `make`."""
        return make(id, **options)

    def register(self, id: str, **options: Any) -> None:
        """See `register`."""
        register(id, **options)


registry = EnvRegistry()

_WITHOUT_EFFECT = ("trials", "local_only", "order_enforce")
"""Old options of `register` that changed no environment of Gym's own, or only its checks."""


def register(
    id: str,
    entry_point: "str | Callable[..., Any] | None" = None,
    reward_threshold: float | None = None,
    nondeterministic: bool = False,
    max_episode_steps: int | None = None,
    kwargs: dict[str, Any] | None = None,
    *,
    timestep_limit: int | None = None,
    tags: dict[str, Any] | None = None,
    **others: Any,
) -> None:
    """Register an environment, with the old interface or the new, for `make` and for `gymnasium.make`.

    Args:
        id: such as "Corridor-v0".
        entry_point: the class, or its import path "my_module:CorridorEnv", or "gym.envs.toy_text:FrozenLakeEnv".
        reward_threshold: the mean return from which the task counts as solved.
        nondeterministic: whether its episodes differ despite equal seeds.
        max_episode_steps: the time limit; `timestep_limit` and the tag of 2016 mean the same.
        kwargs: arguments of the class; arguments of `make` override them.
        timestep_limit: see `max_episode_steps`.
        tags: only the time limit among them is used.
        **others: `trials`, `local_only` and `order_enforce`, which have no effect.

    Raises:
        gymnasium.error.Error: the ID is malformed, or taken by another environment.
        TypeError: there is no such option.

    Example:
        >>> from atari import classic
        >>> class Hallway(classic.Env):
        ...     action_space = classic.spaces.Discrete(2)
        ...     observation_space = classic.spaces.Discrete(10)
        ...     def reset(self):
        ...         self.place = 0
        ...         return self.place
        ...     def step(self, action):
        ...         self.place = max(0, self.place + (1 if action else -1))
        ...         return self.place, float(self.place == 9), self.place == 9, {}
        >>> classic.register("Hallway-v0", Hallway, max_episode_steps=100)
        >>> env = classic.make("Hallway-v0")
        >>> env.reset(), env.step(1)
        (0, (1, 0.0, False, {}))
    """
    for name in others:
        if name not in _WITHOUT_EFFECT:
            raise TypeError(f"register() has no option {name!r}; options of the class go into kwargs={{{name!r}: ...}}")
    if not isinstance(id, str) or not _ID.fullmatch(id):
        raise gymnasium.error.Error(f"an ID is a name, '-v' and a version, such as 'Corridor-v0', got {id!r}")
    if not (isinstance(entry_point, str) and ":" in entry_point) and not callable(entry_point):
        raise gymnasium.error.Error(
            f"entry_point is a class, or where it is ('my_module:CorridorEnv'), got {entry_point!r}"
        )
    taken = gymnasium.registry.get(id)
    if taken is not None and _import_path(taken.entry_point) != _import_path(EntryPoint(entry_point)):
        raise gymnasium.error.Error(
            f"the ID {id!r} is taken by {_import_path(taken.entry_point)}; choose another name or version, "
            f"or first `del gym.envs.registry.env_specs[{id!r}]`"
        )
    limit = max_episode_steps or timestep_limit or (tags or {}).get("wrapper_config.TimeLimit.max_episode_steps")
    registry.env_specs[id] = EnvSpec(id, entry_point, reward_threshold, nondeterministic, limit, dict(kwargs or {}))


def spec(id: str) -> EnvSpec:
    """The `EnvSpec` of an ID, or of its newest version if its own version no longer exists.

    Raises:
        gymnasium.error.UnregisteredEnv: there is no such environment; the message suggests an ID, or a package to
            install.

    Example:
        >>> from atari import classic
        >>> classic.spec("Breakout-v0").id
        'Breakout-v0'
    """
    return registry.env_specs[lookup.resolve(id)]


def load(name: str) -> Callable[..., Any]:
    """The class of an import path, such as "gym.envs.classic_control:CartPoleEnv"."""
    return EntryPoint(name).load()


def make(id: str, **options: Any) -> Env:
    """Make an environment with the old interface.

    Args:
        id: an ID, which may name a module to import first: "my_module:Corridor-v0".
        **options: arguments of the environment.

    Raises:
        gymnasium.error.UnregisteredEnv: there is no such environment; the message suggests an ID, or a package to
            install.
        gymnasium.error.DependencyNotInstalled: the environment needs a package; the message names it.

    Example:
        >>> from atari import classic
        >>> env = classic.make("Breakout-v0")
        >>> observation = env.reset()
        >>> observation, reward, done, info = env.step(env.action_space.sample())
        >>> observation.shape
        (210, 160, 3)
    """
    chosen = spec(id)
    chosen = dataclasses.replace(chosen, kwargs={**chosen.kwargs, **options})
    modern = copy.copy(gymnasium.registry[chosen.id])
    entry_point = modern.entry_point
    env: Env | gymnasium.Env[Any, Any]
    if isinstance(entry_point, EntryPoint):
        env = entry_point.create(**{**quiet_options(entry_point.load()), **chosen.kwargs})
    else:
        options = modern_options(options) if history.is_atari(modern) else options
        modern.kwargs = {**modern.kwargs, **history.atari_changes(modern).kwargs, **options}
        env = _make_modern(modern)
    if not isinstance(env, Env):
        env = adapt(env)
    classic = env if isinstance(env, Adapter) else Checked(env)
    classic.unwrapped.spec = classic.spec = chosen
    return classic if chosen.max_episode_steps is None else TimeLimit(classic, chosen.max_episode_steps)


def _import_path(entry_point: Any) -> str:
    """The import path of an entry point; it stays the same if a notebook defines the class again."""
    if isinstance(entry_point, EntryPoint):
        entry_point = entry_point.entry_point
    if isinstance(entry_point, str):
        return entry_point
    return f"{getattr(entry_point, '__module__', '')}:{getattr(entry_point, '__qualname__', repr(entry_point))}"


def _make_modern(modern: ModernSpec) -> gymnasium.Env[Any, Any]:
    try:
        creator = load_env_creator(modern.entry_point) if isinstance(modern.entry_point, str) else modern.entry_point
    except ModuleNotFoundError as error:
        if error.name != "jax":
            raise
        raise gymnasium.error.DependencyNotInstalled(f"{modern.id} needs JAX: pip install 'gymnasium[jax]'") from None
    modern.kwargs = {**quiet_options(creator), **modern.kwargs}
    modern.max_episode_steps = None  # the caller adds the limit, as an old wrapper
    return gymnasium.make(modern, disable_env_checker=True)


def _classic_spec(modern: ModernSpec) -> EnvSpec:
    changes = history.atari_changes(modern)
    return EnvSpec(
        modern.id,
        _old_entry_point(modern),
        modern.reward_threshold,
        changes.nondeterministic or modern.nondeterministic,
        changes.max_episode_steps or modern.max_episode_steps,
        old_options(modern.kwargs) if history.is_atari(modern) else dict(modern.kwargs),
    )


def _old_entry_point(modern: ModernSpec) -> Any:
    """The entry point as it was registered, or for environments of Gym's own the path of the class here."""
    entry_point = modern.entry_point
    if isinstance(entry_point, EntryPoint):
        return entry_point.entry_point
    if history.is_atari(modern):
        return "gym.envs.atari:AtariEnv"
    if isinstance(entry_point, str):
        return re.sub(r"^gymnasium\.envs\.(classic_control|toy_text)\.\w+:", r"gym.envs.\1:", entry_point)
    return entry_point
