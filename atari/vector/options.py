"""The tasks of a vector environment and its options, checked, and the engine and the spaces made from them."""

import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

import atari._emulator as _emulator
from atari.base.gymnasium_versions import AutoresetMode, autoreset_mode
from atari.base.validation import check_integer, check_known, check_no_name
from atari.cores.compiled import compiled, compiled_for_players, reward_formula
from atari.cores.writes import make_writes
from atari.env.settings import episode_settings, filled, observation_settings, observation_space
from atari.games.actions import PLAYER_ACTIONS, Action, in_continuous_space, joystick_action, make_action_space
from atari.games.game import Game
from atari.roms import find
from atari.roms.image import read_image
from atari.task import Task
from atari.task.checks import NO_LIMIT, check_bool
from atari.task.json_form import identity
from atari.task.resolution import ALIASES, OPTIONS
from atari.task.task import FoundGame, GameLike, look_up
from atari.vector.ale_names import NAMES, ale_defaults, as_task_options
from atari.vector.layout import Layout

_INT64, _ndarray = np.dtype(np.int64), np.ndarray  # looked up once, because every step uses them

_OWN = frozenset(("game", "mode", "difficulty", "interventions", "rules", "rom_md5"))
"""Fields of tasks in which the environments of a vector may differ."""

OF_TASKS = (*OPTIONS, *ALIASES, *NAMES)
"""The options that decide the tasks."""


def resolve_lanes(
    game: GameLike | Sequence[GameLike],
    num_envs: int | None,
    preset: str | None,
    options: Mapping[str, Any],
    others: Iterable[str] = (),
) -> tuple[tuple[Task, ...], bool]:
    """The task of each environment of a vector, and whether ale-py's defaults apply, as for a name without a preset.

    Equal tasks are made once. `others` are names of other options of `AtariVectorEnv`, for the suggestion in an error.

    Raises:
        gymnasium.error.NameNotFound, TypeError, ValueError, FileNotFoundError: see `AtariVectorEnv`.
    """
    listed = _listed(game, num_envs)
    known = (*OF_TASKS, "num_envs", "preset", *others)
    check_known("AtariVectorEnv", [name for name in options if name not in OF_TASKS], known)
    shared = {name: value for name, value in options.items() if name not in ("mode", "difficulty")}
    modes, difficulties = (_spread(name, options.get(name), len(listed)) for name in ("mode", "difficulty"))
    found = {id(one): look_up(one) for one in {id(one): one for one in listed}.values()}
    made: dict[tuple[int, int | None, int | None], Task] = {}
    keys = list(zip(map(id, listed), modes, difficulties, strict=True))
    for key in keys:
        if key not in made:
            own = zip(("mode", "difficulty"), key[1:], strict=True)
            given = {**shared, **{name: value for name, value in own if value is not None}}
            made[key] = task_of_lane(found[key[0]], preset, given)
    return tuple(made[key] for key in keys), preset is None and any(one.bare for one in found.values())


def task_of_lane(found: FoundGame, preset: str | None, options: Mapping[str, Any]) -> Task:
    """The task of an environment of a vector.

    Raises:
        TypeError, ValueError: see `AtariVectorEnv`.
    """
    base = ale_defaults(options, found.environment is not None) if preset is None and found.bare else {}
    kind = found.game.obs_type if isinstance(found.game, Task) else "grayscale" if preset else "rgb"
    task = found.task(preset, as_task_options(options, base, kind), base, owner="AtariVectorEnv")
    if task.sound_obs:
        raise ValueError(
            "sound_obs=True is for single environments, a vector has no sound; use atari.make, or leave it out"
        )
    if isinstance(task.repeat_action_probability, tuple):
        raise ValueError(
            f"repeat_action_probability={task.repeat_action_probability} differs by player, and a vector has one for "
            "all players; use atari.multiplayer, or give a number"
        )
    return task


def _listed(game: GameLike | Sequence[GameLike], num_envs: int | None) -> list[GameLike]:
    if not isinstance(game, Sequence) or isinstance(game, str):
        if num_envs is None:
            raise TypeError("num_envs is needed: how many environments of the game to make")
        return [game] * check_integer("num_envs", num_envs, 1, 1_000_000)
    if len(game) == 0:
        raise ValueError("game must name at least one game")
    count = len(game) if num_envs is None else check_integer("num_envs", num_envs, 1, 1_000_000)
    if count != len(game):
        raise ValueError(f"there must be a game for each of the {count} environments, got {len(game)}")
    return list(game)


def _spread(name: str, value: Any, count: int) -> tuple[int | None, ...]:
    values = [value] * count if value is None or isinstance(value, (int, np.integer)) else value
    known = isinstance(values, (Sequence, np.ndarray)) and not isinstance(values, str)
    if not known or any(isinstance(one, (bool, np.bool_)) for one in values):
        raise TypeError(f"{name} must be an integer, None, or a sequence of these, got {value!r}")
    if len(values) != count:
        raise ValueError(f"there must be a {name} for each of the {count} environments, got {len(values)}")
    try:
        return tuple(None if one is None else operator.index(one) for one in values)
    except TypeError:
        raise TypeError(f"{name} must be an integer, None, or a sequence of these, got {value!r}") from None


@dataclass(frozen=True)
class VectorOptions:
    """The options of a vector environment. `check` makes them from the arguments of `AtariVectorEnv`.

    Attributes:
        tasks: the task of each environment. They differ at most in the game, its mode, difficulty and interventions.
        game_info: whether `info` has the statistics of whole games.
        batch_size, num_threads: never 0.
        layout: the axes and the dtype of observations; `layout.is_engines` is uint8 with the stack first.
        others: see `AtariVectorEnv`.
    """

    tasks: tuple[Task, ...]
    game_info: bool
    rom: str | PathLike[str] | None
    batch_size: int
    num_threads: int
    thread_affinity_offset: int
    autoreset_mode: AutoresetMode
    layout: Layout

    @classmethod
    def check(cls, tasks: tuple[Task, ...], bare: bool, given: Mapping[str, Any]) -> "VectorOptions":
        """The options of `AtariVectorEnv`, checked. `bare`: a game was a name without a preset; `game_info` is False.

        Raises:
            TypeError, ValueError: an option is of the wrong kind or out of range.
        """
        _check_alike(tasks)
        threads = check_integer("num_threads", given["num_threads"], -NO_LIMIT, NO_LIMIT)
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        batch_size = check_integer("batch_size", given["batch_size"], 0, len(tasks)) or len(tasks)
        if given["render_mode"] not in (None, "rgb_array"):
            raise ValueError(f"render_mode must be 'rgb_array' or None, got {given['render_mode']!r}")
        first, game_info = tasks[0], given["game_info"]
        if game_info is None:
            game_info = first.preprocessed and not bare
        return cls(
            tasks=tasks,
            game_info=check_bool("game_info", game_info),
            rom=given["rom"],
            batch_size=batch_size,
            num_threads=min(threads if threads > 0 else cores, len(tasks)),
            thread_affinity_offset=check_integer("thread_affinity_offset", given["thread_affinity_offset"], -1, 10_000),
            autoreset_mode=autoreset_mode(given["autoreset_mode"]),
            layout=Layout.check(first, given["channels_last"], given["dtype"]),
        )

    @property
    def task(self) -> Task:
        """The task of the first environment. The others differ only in game, mode, difficulty and interventions."""
        return self.tasks[0]

    @cached_property
    def identities(self) -> tuple[str, ...]:
        """The task of each environment in the form of its snapshots."""
        return tuple(map(identity, self.tasks))

    @cached_property
    def games(self) -> tuple[Game, ...]:
        """The game of each environment."""
        return tuple(task.definition for task in self.tasks)

    @property
    def players(self) -> int:
        """The number of players of each game."""
        return self.task.players

    def make_engine(self) -> _emulator.VectorEngine:
        """The engine, which has the environments and their threads."""
        writes = self._writes
        games = set(self.games)
        compile_game = compiled if self.players == 1 else compiled_for_players
        native = {game: compile_game(game, read_image(find(game, self.rom))) for game in games}
        seeds = np.random.SeedSequence().generate_state(9 * len(self.games)).reshape(-1, 9).tolist()
        lanes = [
            filled(
                _emulator.LaneSpec(),
                game=native[task.definition],
                actions=list(map(int, actions)),
                action_set=list(map(int, task.begin_actions)),
                mode=task.set_mode,
                difficulty=task.set_difficulty,
                seed=seed,
                **({} if task.reward is None else {"reward": reward_formula(task.definition, task.reward)}),
            )
            for task, actions, seed in zip(self.tasks, self.actions, seeds, strict=True)
        ]
        threads = filled(
            _emulator.VectorSettings(),
            batch_size=self.batch_size,
            threads=self.num_threads,
            first_core=self.thread_affinity_offset,
            autoreset=_emulator.Autoreset[self.autoreset_mode.name],
        )
        engine = _emulator.VectorEngine(lanes, episode_settings(self.task), observation_settings(self.task), threads)
        for index, made in enumerate(writes):
            for write in made:
                engine.add_write(index, write)
        return engine

    @cached_property
    def _writes(self) -> tuple[list[_emulator.Write], ...]:
        """The writes of each environment's interventions. Environments with the same game share them."""
        made = {(task.definition, task.interventions): task for task in self.tasks}
        writes = {key: make_writes(*key) for key in made}
        return tuple(writes[task.definition, task.interventions] for task in self.tasks)

    @cached_property
    def action_sets(self) -> tuple[tuple[Action, ...], ...]:
        """The actions that each environment's game uses."""
        return tuple(task.action_set for task in self.tasks)

    @property
    def mixed(self) -> bool:
        """Whether the games have different sets of actions."""
        return len(set(self.action_sets)) > 1

    @property
    def actions(self) -> tuple[tuple[Action, ...], ...]:
        """For each environment, the action of each index of the action space."""
        return (PLAYER_ACTIONS,) * len(self.games) if self.task.continuous or self.mixed else self.action_sets

    def action_space(self) -> spaces.Space[Any]:
        """The action space of one environment."""
        if self.players > 1:
            return spaces.MultiDiscrete([len(self.actions[0])] * self.players)
        return make_action_space(self.actions[0], self.task.continuous)

    def batched_action_space(self) -> spaces.Space[Any]:
        """The action space of a batch."""
        single = self.action_space()
        if isinstance(single, spaces.MultiDiscrete):  # `batch_space` would make a Box of it
            return spaces.MultiDiscrete(np.tile(single.nvec, (self.batch_size, 1)))
        return batch_space(single, self.batch_size)

    def action_masks(self) -> npt.NDArray[np.bool_] | None:
        """The actions that each game has, (environments, 18) bool; None if all have the same."""
        if self.task.continuous or not self.mixed:
            return None
        return np.array([[action in actions for action in PLAYER_ACTIONS] for actions in self.action_sets])

    def observation_space(self) -> spaces.Space[Any]:
        """The observation space of one environment, in the engine's form: with an axis for the stack."""
        return observation_space(self.task, engines=True)

    def part_names(self) -> tuple[str, str]:
        """The keys of stack and RAM in observations: "" if observations are no dicts, "none" for an absent part."""
        if self.task.kind.is_dict:
            return "image", "ram"
        return ("none", "") if not (self.task.kind.image or self.task.stack_num) else ("", "none")

    def moves(
        self, actions: Any, rows: int | None = None
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32] | None]:
        """The indices of actions, (rows * players,) int64, and the strengths of paddles, (rows,) float32 or None.

        `rows` is `batch_size` if it is None. Indices are not checked for their range.

        Raises:
            TypeError, ValueError: the actions are of the wrong kind or shape.
        """
        if (
            rows is None
            and type(actions) is _ndarray
            and actions.dtype is _INT64
            and actions.shape == self._index_shape
        ):
            return actions, None  # the usual kind needs no checks, which would slow each step
        if isinstance(actions, (list, tuple)):
            for action in actions:
                check_no_name(action, len(self.actions[0]))
        array = np.asarray(actions)
        rows = self.batch_size if rows is None else rows
        continuous = self.task.continuous
        shape = (rows, 3) if continuous else (rows,) if self.players == 1 else (rows, self.players)
        if array.dtype.kind not in ("f" if continuous else "iu"):
            kind = "floats (radius, angle, fire)" if continuous else "integers"
            raise TypeError(f"actions must be {kind} of shape {shape}, got {array.dtype}")
        if array.shape != shape:
            raise ValueError(f"actions must have the shape {shape}, got {array.shape}")
        if continuous:
            return self._motions(array)
        return np.ascontiguousarray(array, np.int64).reshape(-1), None

    def moves_of_sequences(
        self, actions: Any, rows: int
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32] | None, int]:
        """The indices and strengths of `moves` for several steps of each of some environments, and the number of steps.

        Raises:
            TypeError, ValueError: the actions are of the wrong kind or shape.
        """
        array = np.asarray(actions)
        row = (3,) if self.task.continuous else () if self.players == 1 else (self.players,)
        if array.ndim < 2 or len(array) != rows or array.shape[2:] != row or not array.shape[1]:
            shape = ", ".join(map(str, (rows, "steps", *row)))
            raise ValueError(f"actions must have the shape ({shape}), with a step or more, got {array.shape}")
        indices, strengths = self.moves(array.reshape(-1, *row), rows * array.shape[1])
        return indices, strengths, array.shape[1]

    @cached_property
    def _index_shape(self) -> tuple[int, ...]:
        """The shape of a batch of one player's action indices; (-1,) if actions are no indices."""
        return (-1,) if self.task.continuous or self.players > 1 else (self.batch_size,)

    def _motions(self, actions: npt.NDArray[Any]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32]]:
        """Indices and strengths of continuous actions, computed in float32 as in CALE."""
        with np.errstate(over="ignore"):
            radius, angle, fire = np.ascontiguousarray(actions.T, np.float32)
        good = in_continuous_space(radius, angle, fire)
        if not good.all():
            row = int(np.argmin(good))
            raise ValueError(
                f"a continuous action is radius 0..1, angle -pi..pi, fire 0..1, got {actions[row]} in row {row}"
            )
        return joystick_action(radius, angle, fire, np.float32(self.task.continuous_action_threshold)), radius


def _check_alike(tasks: tuple[Task, ...]) -> None:
    first = tasks[0]
    for task in dict.fromkeys(tasks):
        differing = {name: pair for name, pair in first.differences(task).items() if name not in _OWN}
        if task.action_set == first.action_set:  # all of Boxing's actions are also its minimal ones
            differing.pop("actions", None)
        if differing:
            name, (one, other) = next(iter(differing.items()))
            raise ValueError(
                f"environments of a vector play tasks that differ in the game, its mode, difficulty and interventions "
                f"only; these differ in {name}: {one!r} and {other!r}"
            )
        if first.img_height is None and task.definition.screen.shape != first.definition.screen.shape:
            raise ValueError(
                f"the screens of {first.game} and {task.game} have other sizes; add img_height=84, img_width=84"
            )
