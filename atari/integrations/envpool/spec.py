"""`EnvPoolSpec`: EnvPool's options of a task, and the arrays and the vector environment that they describe."""

import difflib
import math
import sys
from collections import namedtuple
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from atari.base.extras import import_extra, pip_install
from atari.base.validation import check_integer
from atari.env.settings import image_shape
from atari.games.catalog import playable_ids
from atari.task import Task
from atari.task.checks import check_bool
from atari.task.env_ids import stem
from atari.task.observation_kinds import with_image
from atari.task.task import FoundGame, GameLike, look_up
from atari.vector import AtariVectorEnv

_MOST = 2**31 - 1
_DEFAULTS = {
    "num_envs": 1,
    "batch_size": None,
    "num_threads": None,
    "max_num_players": 1,
    "thread_affinity_offset": -1,
    "base_path": "",
    "seed": 42,
    "env_seed": (),
    "gym_reset_return_info": False,
    "max_episode_steps": 27_000,
    "stack_num": 4,
    "frame_skip": 4,
    "noop_max": 30,
    "zero_discount_on_life_loss": False,
    "episodic_life": False,
    "reward_clip": False,
    "use_fire_reset": True,
    "img_height": 84,
    "img_width": 84,
    "task": "",
    "mode": -1,
    "difficulty": -1,
    "full_action_space": False,
    "repeat_action_probability": 0.0,
    "use_inter_area_resize": True,
    "gray_scale": True,
}

_SAME = (
    "stack_num episodic_life img_height img_width mode difficulty full_action_space repeat_action_probability".split()
)
_FIELDS = {"frame_skip": "frameskip", "reward_clip": "reward_clipping", **dict(zip(_SAME, _SAME, strict=True))}
"""The `Task` fields of EnvPool's options, under the same or another name; -1 is the default."""

_WITHOUT_EFFECT = {
    "max_num_players": "a game has one player",
    "base_path": "ROM files are searched for by atari.roms",
    "use_inter_area_resize": "images are resized by areas",
}
"""EnvPool's options that must have their default, with the reason."""

Config = namedtuple("Config", _DEFAULTS, defaults=_DEFAULTS.values())  # type: ignore[misc]
"""EnvPool's options with their values."""

_REGISTERED: dict[str, tuple[str, dict[str, Any]]] = {}
"""The games and options of the tasks that `register` has added."""


_FLOAT32 = (float(np.finfo(np.float32).min), float(np.finfo(np.float32).max))
_INT32 = (-(2**31), 2**31 - 1)


@dataclass(frozen=True)
class ArraySpec:
    """A row of an array; -1 in its shape stands for the players, who are one here.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> envpool.make_spec("Pong-v5").state_array_spec["obs"].shape
        [4, 84, 84]
    """

    dtype: npt.DTypeLike
    shape: list[int]
    bounds: tuple[Any, Any]
    element_wise_bounds: tuple[Any, Any] = ((), ())
    is_discrete: bool = False

    @property
    def minimum(self) -> Any:
        """The least value, or the array of them."""
        return np.array(self.element_wise_bounds[0]) if self.element_wise_bounds[0] else self.bounds[0]

    @property
    def maximum(self) -> Any:
        """The greatest value, or the array of them."""
        return np.array(self.element_wise_bounds[1]) if self.element_wise_bounds[1] else self.bounds[1]

    def __repr__(self) -> str:
        return f"ArraySpec(shape={self.shape}, dtype={self.dtype}, minimum={self.minimum}, maximum={self.maximum})"


def _spec(dtype: npt.DTypeLike, shape: list[int], bounds: tuple[Any, Any]) -> ArraySpec:
    return ArraySpec(np.dtype(dtype), shape, bounds)


def state_arrays(shape: tuple[int, ...]) -> dict[str, ArraySpec]:
    """The arrays that `recv` returns, with observations of this shape, by EnvPool's names."""
    return {
        "info:env_id": _spec(np.int32, [], _INT32),
        "info:players.env_id": _spec(np.int32, [-1], _INT32),
        "elapsed_step": _spec(np.int32, [], _INT32),
        "done": _spec(np.bool_, [], (False, True)),
        "reward": _spec(np.float32, [-1], _FLOAT32),
        "discount": _spec(np.float32, [-1], (0.0, 1.0)),
        "step_type": _spec(np.int32, [], _INT32),
        "trunc": _spec(np.bool_, [], (False, True)),
        "obs": _spec(np.uint8, [*shape], (0, 255)),
        "info:lives": _spec(np.int32, [-1], _INT32),
        "info:reward": _spec(np.float32, [-1], _FLOAT32),
        "info:terminated": _spec(np.int32, [-1], (0, 1)),
        "info:ram": _spec(np.uint8, [128], (0, 255)),
    }


def action_arrays(actions: int) -> dict[str, ArraySpec]:
    """The arrays that `send` takes, for this number of actions, by EnvPool's names."""
    return {
        "env_id": _spec(np.int32, [], _INT32),
        "players.env_id": _spec(np.int32, [-1], _INT32),
        "action": _spec(np.int32, [-1], (0, actions - 1)),
    }


@dataclass(eq=False)
class EnvPoolSpec:
    """The options of a task. Scripts may set other attributes, such as `id`.

    Attributes:
        config: every option of EnvPool's with its value; a named tuple, which `gen_config` makes.
        played: the task that these options define; None takes it from `config`.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> spec = envpool.make_spec("Pong-v5", num_envs=4)
        >>> spec.config.num_envs
        4
    """

    config: Any
    played: Any = None  # a Task

    reward_threshold = None
    gen_config = Config

    def __post_init__(self) -> None:
        if self.played is None:
            config = self.config._asdict()
            spec = make_spec(config["task"], **{k: v for k, v in config.items() if v != _DEFAULTS[k] and k != "task"})
            self.config, self.played = spec.config, spec.played

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.config._asdict().items())})"

    @cached_property
    def state_array_spec(self) -> dict[str, ArraySpec]:
        """The arrays that `recv` returns, by EnvPool's names."""
        return state_arrays(self.gymnasium_observation_space.shape)

    @cached_property
    def action_array_spec(self) -> dict[str, ArraySpec]:
        """The arrays that `send` takes, by EnvPool's names."""
        return action_arrays(len(self.played.action_set))

    def observation_spec(self) -> Any:
        """The specs of dm_env of one environment's arrays, a named tuple.

        Raises:
            gymnasium.error.DependencyNotInstalled: dm-env is not installed.
        """
        return import_dm().observation_spec(self.state_array_spec)

    def action_spec(self) -> Any:
        """The spec of dm_env of one environment's action; see `observation_spec`."""
        return import_dm().as_dm("action", self.action_array_spec["action"])

    @cached_property
    def gymnasium_observation_space(self) -> Any:
        """The observation space of one environment, (stack_num, img_height, img_width), 3 * stack_num in RGB."""
        return self._observation_space(gymnasium.spaces)

    @cached_property
    def gymnasium_action_space(self) -> Any:
        """The action space of one environment."""
        return self._action_space(gymnasium.spaces)

    @cached_property
    def observation_space(self) -> Any:
        """The observation space of one environment; a space of Gym if `gym` is imported."""
        return self._observation_space(sys.modules.get("gym.spaces", gymnasium.spaces))

    @cached_property
    def action_space(self) -> Any:
        """The action space of one environment; a space of Gym if `gym` is imported."""
        return self._action_space(sys.modules.get("gym.spaces", gymnasium.spaces))

    def make_vector(self) -> AtariVectorEnv:
        """The vector environment. It returns images and RAM.

        Raises:
            TypeError, ValueError: `batch_size` or a number of threads is wrong.
            FileNotFoundError: there is no ROM of the game.
        """
        config = self.config
        return AtariVectorEnv(
            self.played,
            config.num_envs,
            batch_size=config.batch_size,
            num_threads=config.num_threads,
            thread_affinity_offset=config.thread_affinity_offset,
        )

    def _observation_space(self, spaces: Any) -> Any:
        task = self.played
        channels = (task.stack_num or 1) * math.prod(task.kind.colours)
        return spaces.Box(0, 255, (channels, *image_shape(task)), np.uint8)

    def _action_space(self, spaces: Any) -> Any:
        return spaces.Discrete(len(self.played.action_set))


def import_dm() -> Any:
    """The module `atari.integrations.envpool.dm`.

    Raises:
        gymnasium.error.DependencyNotInstalled: dm-env is not installed.
    """
    return import_extra("atari.integrations.envpool.dm", f"dm_env's interface needs dm-env: {pip_install('dm-env')}")


def task_ids() -> dict[str, str]:
    """EnvPool's names of the tasks, each with the ID of its game."""
    own = {f"{stem(game).replace('3D', '3d')}-v5": game for game in playable_ids()}
    return {**own, **{name: game for name, (game, _) in _REGISTERED.items()}}


def register(
    task_id: str,
    import_path: str,
    spec_cls: str,
    dm_cls: str,
    gymnasium_cls: str,
    aliases: Sequence[str] = (),
    **kwargs: Any,
) -> None:
    """Add a name for an Atari game with other defaults.

    Args:
        task_id, aliases: the new names.
        import_path, spec_cls, dm_cls, gymnasium_cls: "envpool.atari" and its classes.
        kwargs: `task`, the game's name, and EnvPool's options.

    Raises:
        TypeError, ValueError: a name is taken, the module or a class is another one, or see `make_spec`.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> classes = ("AtariEnvSpec", "AtariDMEnvPool", "AtariGymnasiumEnvPool")
        >>> envpool.register("ShortPong-v5", "envpool.atari", *classes, task="pong", max_episode_steps=100)
        >>> envpool.make_spec("ShortPong-v5").config.max_episode_steps
        100
    """
    wanted = ("envpool.atari", "AtariEnvSpec", "AtariDMEnvPool", "AtariGymnasiumEnvPool")
    given = (import_path.removeprefix("atari.integrations."), spec_cls, dm_cls, gymnasium_cls)
    if given != wanted:
        raise ValueError(f"only Atari games can be registered here, with {', '.join(wanted)}; got {', '.join(given)}")
    names = (task_id, *aliases)
    if taken := [name for name in names if name in task_ids()]:
        raise ValueError(f"{taken[0]!r} is taken; choose another name")
    if "task" not in kwargs:
        raise TypeError("register() needs task, the name of a game, such as task='pong'")
    options = {name: value for name, value in kwargs.items() if name != "task"}
    make_spec(kwargs["task"], **options)  # raises the errors before anything is registered
    _REGISTERED.update(dict.fromkeys(names, (kwargs["task"], options)))


def make_spec(task_id: GameLike, **options: Any) -> EnvPoolSpec:
    """The spec of a task, such as "Breakout-v5", with EnvPool's options.

    Args:
        task_id: a name of EnvPool's, or a game's name, the path of a game file or a `Game`, with EnvPool's defaults; an
            environment ID ("ALE/Breakout-v5"), which decides sticky actions and actions; or an `atari.Task`, whose
            fields replace all of EnvPool's defaults.
        options: EnvPool's options.

    Raises:
        TypeError: there is no such option; the message suggests the nearest.
        ValueError: there is no such task, or an option has a value that is not supported.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> spec = envpool.make_spec("Pong-v5", num_envs=4)
        >>> spec.action_space, spec.observation_space.shape
        (Discrete(6), (4, 84, 84))
    """
    if isinstance(task_id, str) and task_id in _REGISTERED:
        task_id, defaults = _REGISTERED[task_id]
        options = {**defaults, **options}
    for name in options:
        if name not in _DEFAULTS or name == "task":
            near = difflib.get_close_matches(name, _DEFAULTS, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(_DEFAULTS)}"
            raise TypeError(f"there is no option {name!r}; {hint}")
    found = _look_up(task_id)
    base = _task(found, {})
    given = {**_DEFAULTS, **_of_task(base, isinstance(found.game, Task)), **options, "task": base.game}
    for name, because in _WITHOUT_EFFECT.items():
        if given[name] != _DEFAULTS[name]:
            raise ValueError(f"{because}; leave {name}={given[name]!r} out")
    given["num_envs"] = check_integer("num_envs", given["num_envs"], 1, 1_000_000)
    batch_size = check_integer("batch_size", given["batch_size"] or 0, 0, given["num_envs"])
    given["batch_size"] = batch_size or given["num_envs"]
    given["env_seed"] = [check_integer("each of env_seed", seed, 0, _MOST) for seed in given["env_seed"]]
    if len(given["env_seed"]) not in (0, given["num_envs"]):
        raise ValueError(f"env_seed must have a seed for each of {given['num_envs']} environments")
    given["num_threads"] = check_integer("num_threads", given["num_threads"] or 0, 0, _MOST)
    for name in {"stack_num", "img_height", "img_width"} & options.keys():
        given[name] = check_integer(name, given[name], 1, 10_000)
    config = Config(**given)
    return EnvPoolSpec(config, _task(found, _as_fields(config, options)))


def _task(found: FoundGame, fields: Mapping[str, Any]) -> Task:
    if isinstance(task := found.game, Task):
        if task.players > 1:
            raise ValueError(f"a game has one player, and the task has players={task.players}; use AtariVectorEnv")
        if not task.kind.image:
            raise ValueError("EnvPool's environments show images and RAM, and the task has obs_type='ram'; use 'dict'")
        return task.replace(**{"stack_num": task.stack_num or 1, **fields})
    return found.task_for_agent("envpool", fields, owner="make_spec")


def _look_up(task_id: GameLike) -> FoundGame:
    try:
        return look_up(task_ids().get(str(task_id), task_id))
    except (gymnasium.error.NameNotFound, ValueError):
        if not isinstance(task_id, str) or task_id.endswith(".toml"):
            raise
        near = difflib.get_close_matches(task_id.split("/")[-1], task_ids(), n=1, cutoff=0.4)
        hint = f"did you mean {near[0]!r}?" if near else "envpool.list_all_envs() lists them"
        raise ValueError(f"there is no task {task_id!r}; {hint}") from None


def _of_task(base: Task, whole: bool) -> dict[str, Any]:
    """EnvPool's options with the values of a whole task, or of an ID, that differ from EnvPool's defaults."""
    own = {"repeat_action_probability": base.repeat_action_probability, "full_action_space": base.actions == "full"}
    if not whole:
        return own
    return {
        **{name: getattr(base, field) for name, field in _FIELDS.items() if name not in own},
        **own,
        "noop_max": base.noops[1],
        "use_fire_reset": base.fire != "never",
        "gray_scale": base.kind.is_gray,
        "max_episode_steps": None if base.max_frames is None else base.max_frames // base.frames[0],
    }


def _as_fields(config: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a task that EnvPool's options set; other fields keep the values of the base."""
    fields = {
        field: None if options[name] == -1 else options[name] for name, field in _FIELDS.items() if name in options
    }
    fields["obs_type"] = with_image(gray=check_bool("gray_scale", config.gray_scale), ram=True)
    if "noop_max" in options:
        fields["noops"] = (1, check_integer("noop_max", config.noop_max, 1, 1_000_000))
    if {"frame_skip", "max_episode_steps"} & options.keys():
        skip = check_integer("frame_skip", config.frame_skip, 1, 10_000)
        if config.max_episode_steps is not None or "max_episode_steps" in options:
            limit = skip * check_integer("max_episode_steps", config.max_episode_steps, 1, _MOST)
            fields["max_frames"] = limit if limit <= _MOST else None
    if "use_fire_reset" in options:
        fires = check_bool("use_fire_reset", config.use_fire_reset)
        fields |= {"fire": "after_noops", "fire_counts": True} if fires else {"fire": "never"}
    return fields
