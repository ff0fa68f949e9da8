"""`EnvPoolSpec`: EnvPool's options of a task, and the vector environment that they describe."""

import difflib
import sys
from collections import namedtuple
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import gymnasium
import numpy as np

from atari.env_ids import stem
from atari.games.catalog import games
from atari.task import Task
from atari.validation import check_integer
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

_OF_TASK = (
    "stack_num",
    "episodic_life",
    "img_height",
    "img_width",
    "mode",
    "difficulty",
    "full_action_space",
    "repeat_action_probability",
)
"""EnvPool's options that a `Task` has by the same name; -1 is the default."""

_WITHOUT_EFFECT = {
    "max_num_players": "a game has one player",
    "base_path": "ROM files are searched for by atari.roms",
    "zero_discount_on_life_loss": "no discount is returned",
    "use_inter_area_resize": "images are resized by areas",
}
"""EnvPool's options that are refused unless they have their default, with the reason."""

Config = namedtuple("Config", _DEFAULTS)  # type: ignore[misc]
"""EnvPool's options with their values."""


@dataclass(eq=False)
class EnvPoolSpec:
    """The options of a task. Scripts may set other attributes, such as `id`.

    Attributes:
        config: every option of EnvPool's with its value, a named tuple.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> spec = envpool.make_spec("Pong-v5", num_envs=4)
        >>> spec.config.num_envs
        4
    """

    config: Any

    reward_threshold = None

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
        """The observation space of one environment; of Gym, if `gym` is imported."""
        return self._observation_space(sys.modules.get("gym.spaces", gymnasium.spaces))

    @cached_property
    def action_space(self) -> Any:
        """The action space of one environment; of Gym, if `gym` is imported."""
        return self._action_space(sys.modules.get("gym.spaces", gymnasium.spaces))

    def make_vector(self) -> AtariVectorEnv:
        """The vector environment. It returns images and RAM.

        Raises:
            TypeError, ValueError: an option is of the wrong kind or out of range.
            FileNotFoundError: there is no ROM of the game.
        """
        config = self.config
        return AtariVectorEnv(
            self.as_task(),
            config.num_envs,
            batch_size=config.batch_size,
            num_threads=config.num_threads,
            thread_affinity_offset=config.thread_affinity_offset,
        )

    def as_task(self) -> Task:
        """What these options play.

        Raises:
            TypeError, ValueError: an option is of the wrong kind or out of range.
        """
        config = self.config
        skip = check_integer("frame_skip", config.frame_skip, 1, 10_000)
        limit = skip * check_integer("max_episode_steps", config.max_episode_steps, 1, _MOST)
        given = {name: getattr(config, name) for name in _OF_TASK}
        options: dict[str, Any] = {name: None if value == -1 else value for name, value in given.items()}
        fire: dict[str, Any] = {} if config.use_fire_reset else {"fire": "never"}
        return Task.of(
            config.task,
            preset="envpool",
            **options,
            obs_type="dict" if config.gray_scale else "rgb_dict",
            reward_clipping=config.reward_clip,
            frameskip=skip,
            noops=(1, check_integer("noop_max", config.noop_max, 1, 1_000_000)),
            max_frames=limit if limit <= _MOST else None,
            **fire,
        )

    def _observation_space(self, spaces: Any) -> Any:
        config = self.config
        channels = config.stack_num * (1 if config.gray_scale else 3)
        return spaces.Box(0, 255, (channels, config.img_height, config.img_width), np.uint8)

    def _action_space(self, spaces: Any) -> Any:
        game = games.find(self.config.task)
        return spaces.Discrete(len(game.legal_actions if self.config.full_action_space else game.minimal_actions))


def task_ids() -> dict[str, str]:
    """EnvPool's names of the tasks, each with the ID of its game."""
    return {f"{stem(game.id).replace('3D', '3d')}-v5": game.id for game in games.playable()}


def make_spec(task_id: str, **options: Any) -> EnvPoolSpec:
    """The spec of a task, such as "Breakout-v5", with EnvPool's options.

    Raises:
        TypeError: there is no such option; the nearest is suggested.
        ValueError: there is no such task, or an option has a value that is not supported.

    Example:
        >>> import atari.integrations.envpool as envpool
        >>> spec = envpool.make_spec("Pong-v5", num_envs=4)
        >>> spec.action_space, spec.observation_space.shape
        (Discrete(6), (4, 84, 84))
    """
    tasks = task_ids()
    if task_id not in tasks:
        near = difflib.get_close_matches(str(task_id).split("/")[-1], tasks, n=1, cutoff=0.4)
        hint = f"did you mean {near[0]!r}?" if near else "envpool.list_all_envs() lists them"
        raise ValueError(f"there is no task {task_id!r}; {hint}")
    for name in options:
        if name not in _DEFAULTS or name == "task":
            near = difflib.get_close_matches(name, _DEFAULTS, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(_DEFAULTS)}"
            raise TypeError(f"there is no option {name!r}; {hint}")
    given = {**_DEFAULTS, **options, "task": tasks[task_id]}
    for name, because in _WITHOUT_EFFECT.items():
        if given[name] != _DEFAULTS[name]:
            raise ValueError(f"{because}; leave {name}={given[name]!r} out")
    given["num_envs"] = check_integer("num_envs", given["num_envs"], 1, 1_000_000)
    batch_size = check_integer("batch_size", given["batch_size"] or 0, 0, given["num_envs"])
    given["batch_size"] = batch_size or given["num_envs"]
    given["num_threads"] = check_integer("num_threads", given["num_threads"] or 0, 0, _MOST)
    for name in ("stack_num", "img_height", "img_width"):
        given[name] = check_integer(name, given[name], 1, 10_000)
    return EnvPoolSpec(Config(**given))
