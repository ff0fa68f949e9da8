"""Gym's registry, as another interface to Gymnasium's.

Only Gymnasium's registry has entries, so both interfaces can make each registered environment. An `EnvSpec` has the
fields of Gym's specs; each lookup derives it from Gymnasium's spec, with Gym's limits for Atari games.
"""

import contextlib
import copy
import dataclasses
import inspect
import re
from collections.abc import Callable, Iterator, MutableMapping, ValuesView
from importlib import metadata
from typing import Any

import gymnasium
from gymnasium.envs import registration as _registration
from gymnasium.envs.registration import EnvSpec as ModernSpec
from gymnasium.envs.registration import (
    find_highest_version,
    get_env_id,
    load_env_creator,
    namespace,
)

from atari.classic import gym_ids
from atari.classic.adapter import Adapter, adapt, quiet_options
from atari.classic.checks import Checked
from atari.classic.core import Env
from atari.classic.envs.atari import modern_options, old_options
from atari.classic.modern import EntryPoint
from atari.classic.spec import Spec
from atari.classic.wrappers.episodes import AutoResetWrapper, TimeLimit

__all__ = [
    "ENV_ID_RE",
    "EnvRegistry",
    "EnvSpec",
    "EnvSpecs",
    "env_id_re",
    "find_highest_version",
    "get_env_id",
    "load",
    "load_env_plugins",
    "make",
    "namespace",
    "parse_env_id",
    "register",
    "registry",
    "spec",
]

_ID = re.compile(r"(?:[\w-]+/)?[\w:.-]+-v(\d+)")
ENV_ID_RE = _registration.ENV_ID_RE
env_id_re = re.compile(r"^(?:[\w:-]+\/)?([\w:.-]+)-v(\d+)$")
"""The form of an ID, whose first group is the name and whose second is the version."""


class EnvSpec(Spec):
    """An entry of the registry, which can make its environment."""

    def make(self, **options: Any) -> Env:
        """Make the environment."""
        return make(self.id, **options)


class EnvSpecs(MutableMapping[str, EnvSpec]):
    """All specs by ID; after deleting one, its ID can be registered again."""

    def __getitem__(self, env_id: str) -> EnvSpec:
        if not gym_ids.is_alive(env_id):
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
        gym_ids.load_robotics()
        return iter([env_id for env_id in gymnasium.registry if gym_ids.is_alive(env_id)])

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

    def spec(self, path: str) -> EnvSpec:
        """See `spec`."""
        return spec(path)

    def make(self, path: str, **kwargs: Any) -> Env:
        """See `make`."""
        return self.spec(path).make(**kwargs)

    @contextlib.contextmanager
    def namespace(self, ns: str) -> Iterator[None]:
        """IDs registered inside have this namespace."""
        with namespace(ns):
            yield

    def register(self, id: str, **options: Any) -> None:
        """See `register`."""
        register(id, **options)


registry = EnvRegistry()

_WITHOUT_EFFECT = ("trials", "local_only", "max_episode_seconds")
"""Old options of `register` that changed no environment of Gym's own, or only its checks."""


def register(
    id: str,
    entry_point: "str | Callable[..., Any] | None" = None,
    reward_threshold: float | None = None,
    nondeterministic: bool = False,
    max_episode_steps: int | None = None,
    order_enforce: bool = True,
    autoreset: bool = False,
    disable_env_checker: bool = False,
    apply_api_compatibility: bool = False,
    *,
    kwargs: dict[str, Any] | None = None,
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
        order_enforce: has no effect: a step before the first reset is always an error.
        autoreset: False; put `AutoResetWrapper` around the environment instead.
        disable_env_checker: has no effect: common mistakes are always errors.
        apply_api_compatibility: has no effect: environments of both interfaces are recognised.
        kwargs: arguments of the class; arguments of `make` override them.
        timestep_limit: see `max_episode_steps`.
        tags: only the time limit among them is used.
        **others: `trials`, `local_only` and `max_episode_seconds`, which have no effect.

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
    if autoreset:
        raise gymnasium.error.Error(
            "register() has no autoreset=True; put gym.wrappers.AutoResetWrapper around the environment, or make it by "
            "gym.make(id, autoreset=True)"
        )
    if max_episode_steps is not None and not isinstance(order_enforce, bool):
        raise TypeError(f"the arguments of the class are given as kwargs={order_enforce!r}")
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
    registry.env_specs[id] = EnvSpec(
        id, entry_point, reward_threshold, nondeterministic, limit, order_enforce, dict(kwargs or {})
    )


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
    return registry.env_specs[gym_ids.resolve(id)]


def load(name: str) -> Callable[..., Any]:
    """The class of an import path, such as "gym.envs.classic_control:CartPoleEnv"."""
    return EntryPoint(name).load()


def make(
    id: str,
    max_episode_steps: int | None = None,
    autoreset: bool = False,
    apply_api_compatibility: bool | None = None,
    disable_env_checker: bool | None = None,
    **options: Any,
) -> Env:
    """Make an environment with the old interface.

    Args:
        id: an ID, which may name a module to import first: "my_module:Corridor-v0".
        max_episode_steps: the time limit; None means that of the spec.
        autoreset: begin new episodes by itself, see `AutoResetWrapper`.
        apply_api_compatibility: has no effect: environments of both interfaces are recognised.
        disable_env_checker: has no effect: common mistakes are always errors.
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
    creator = gymnasium.registry[chosen.id].entry_point
    if (
        max_episode_steps is not None
        and isinstance(creator, EntryPoint)
        and "max_episode_steps" in inspect.signature(creator.load()).parameters
    ):
        options["max_episode_steps"], max_episode_steps = max_episode_steps, None
    limit = chosen.max_episode_steps if max_episode_steps is None else max_episode_steps
    chosen = dataclasses.replace(chosen, kwargs={**chosen.kwargs, **options}, max_episode_steps=limit)
    modern = copy.copy(gymnasium.registry[chosen.id])
    entry_point = modern.entry_point
    env: Env | gymnasium.Env[Any, Any]
    if isinstance(entry_point, EntryPoint):
        env = entry_point.create(**{**quiet_options(entry_point.load()), **chosen.kwargs})
    else:
        if gym_ids.is_atari(modern):
            options = {"max_num_frames_per_episode": None, **modern_options(options)}
        modern.kwargs = {**modern.kwargs, **options}
        env = _make_modern(modern)
    if not isinstance(env, Env):
        env = adapt(env)
    classic = env if isinstance(env, Adapter) else Checked(env)
    classic.unwrapped.spec = classic.spec = chosen
    limited = classic if limit is None else TimeLimit(classic, limit)
    return AutoResetWrapper(limited) if autoreset else limited


def parse_env_id(id: str) -> tuple[str | None, str, int | None]:
    """The namespace, name and version of an ID; None for a part that it lacks.

    Raises:
        gymnasium.error.Error: it is malformed.

    Example:
        >>> from atari.classic.envs.registration import parse_env_id
        >>> parse_env_id("ALE/Pong-v5")
        ('ALE', 'Pong', 5)
    """
    return _registration.parse_env_id(id)


def load_env_plugins(entry_point: str = "gym.envs") -> None:
    """Call the functions that installed packages offer under `entry_point`; each registers environments.

    The name of an offer is the namespace of its IDs, except "__root__" and "__internal__", which have none.
    """
    for plugin in metadata.entry_points(group=entry_point):
        space = contextlib.nullcontext() if plugin.name.startswith("__") else namespace(plugin.name)
        with space:
            plugin.load()()


def __getattr__(name: str) -> Any:
    if name == "current_namespace":  # it changes inside `namespace`
        return _registration.current_namespace
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


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
    is_atari = gym_ids.is_atari(modern)
    return EnvSpec(
        modern.id,
        _old_entry_point(modern),
        modern.reward_threshold,
        modern.nondeterministic or (is_atari and gym_ids.is_random_game(modern.id)),
        gym_ids.atari_steps(modern.id) if is_atari else modern.max_episode_steps,
        kwargs=old_options(modern.kwargs) if is_atari else dict(modern.kwargs),
    )


def _old_entry_point(modern: ModernSpec) -> Any:
    """The entry point as it was registered, or for environments of Gym's own the path of the class here."""
    entry_point = modern.entry_point
    if isinstance(entry_point, EntryPoint):
        return entry_point.entry_point
    if gym_ids.is_atari(modern):
        return "gym.envs.atari:AtariEnv"
    if isinstance(entry_point, str):
        return re.sub(r"^gymnasium\.envs\.(classic_control|toy_text)\.\w+:", r"gym.envs.\1:", entry_point)
    return entry_point
