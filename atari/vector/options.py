"""The options of a vector environment, checked, and what is made from them: the engine and the spaces."""

import operator
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any, get_args

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

from atari import _emulator
from atari._gymnasium import AutoresetMode
from atari.actions import PLAYER_ACTIONS, Action, in_continuous_space, joystick_action, make_action_space
from atari.cores.native import compiled
from atari.cores.options import CoreOptions
from atari.cores.writes import make_writes
from atari.games.catalog import games as catalog
from atari.games.game import Game
from atari.games.interventions import Intervention, resolve
from atari.multiplayer.core import compiled_for_players, rules_of
from atari.protocols import Protocol
from atari.roms import find
from atari.roms.image import read_image
from atari.validation import check_clip_reward, check_frameskip, check_integer, check_name, check_probability
from atari.vector.layout import Layout
from atari.vector.players import check_modes, check_players, fill_defaults
from atari.vector.settings import NO_LIMIT, filled, filled_by_name, task_of

_INT64, _ndarray = np.dtype(np.int64), np.ndarray  # found once: they are used at every step


@dataclass(frozen=True)
class VectorOptions:
    """The options of a vector environment. `check` makes them from the arguments of `AtariVectorEnv`.

    Attributes:
        games, modes, difficulties, interventions: by environment; None is the default mode or difficulty.
        batch_size, num_threads: as they are, never 0.
        threshold: `continuous_action_threshold`.
        obs_type: "grayscale", "rgb", "ram" or "dict".
        layout: the axes and the dtype of observations; `layout.is_engines` is uint8 with the stack first.
        protocol: all that decides how games begin, are played and end, of a preset or of the arguments.
        players: of each game, at least 1.
        others: as `AtariVectorEnv` takes them.
    """

    games: tuple[Game, ...]
    modes: tuple[int | None, ...]
    difficulties: tuple[int | None, ...]
    rom: str | PathLike[str] | None
    batch_size: int
    num_threads: int
    thread_affinity_offset: int
    continuous: bool
    threshold: np.float32
    autoreset_mode: AutoresetMode
    img_height: int
    img_width: int
    obs_type: str
    grayscale: bool
    stack_num: int
    layout: Layout
    preset: str | Protocol | None
    protocol: Protocol
    interventions: tuple[tuple[Intervention, ...], ...]
    players: int

    @classmethod
    def check(cls, **given: Any) -> "VectorOptions":
        """The options of `AtariVectorEnv`, checked.

        Raises:
            TypeError, ValueError: one is of the wrong kind or out of range.
        """
        games = _check_games(given["game"], given["num_envs"], given["players"] is not None)
        players = check_players(given["players"], games)
        given = fill_defaults(given)
        threads = check_integer("num_threads", given["num_threads"], -NO_LIMIT, NO_LIMIT)
        batch_size = check_integer("batch_size", given["batch_size"], 0, len(games)) or len(games)
        if given["render_mode"] not in (None, "rgb_array"):
            raise ValueError(f"render_mode must be 'rgb_array' or None, got {given['render_mode']!r}")
        obs_type, grayscale = _check_obs_type(given["obs_type"], bool(given["grayscale"]))
        if isinstance(given["preset"], str) and obs_type == "rgb":
            raise ValueError("the observations of a preset are gray; leave obs_type='rgb' out")
        modes = _spread("mode", given["mode"], len(games))
        difficulties = _spread("difficulty", given["difficulty"], len(games))
        if players > 1:
            modes = check_modes(games, modes, difficulties, players)
        options = cls(
            games=games,
            modes=modes,
            difficulties=difficulties,
            rom=given["rom"],
            batch_size=batch_size,
            num_threads=min(threads if threads > 0 else _cores(), len(games)),
            thread_affinity_offset=check_integer("thread_affinity_offset", given["thread_affinity_offset"], -1, 10_000),
            continuous=bool(given["continuous"]),
            threshold=np.float32(
                check_probability("continuous_action_threshold", given["continuous_action_threshold"])
            ),
            autoreset_mode=_check_autoreset(given["autoreset_mode"]),
            img_height=check_integer("img_height", given["img_height"], 1, NO_LIMIT),
            img_width=check_integer("img_width", given["img_width"], 1, NO_LIMIT),
            obs_type=obs_type,
            grayscale=grayscale,
            stack_num=check_integer("stack_num", given["stack_num"], 1, 10_000),
            layout=Layout.check(
                given["channels_last"], given["dtype"], obs_type, players if given["agent_indicator"] else 0
            ),
            preset=given["preset"] if players == 1 else None,
            protocol=_check_protocol(given),
            interventions=tuple(resolve(game, given["interventions"]) for game in games),
            players=players,
        )
        if players > 1:
            return options
        if options.protocol.third_action:
            _check_third_actions(options.action_sets, games)
        for game, mode, difficulty in set(zip(games, options.modes, options.difficulties, strict=True)):
            CoreOptions.check(
                game,
                repeat_action_probability=options.protocol.repeat_action_probability,
                mode=mode,
                difficulty=difficulty,
                frame_skip=1,
                max_num_frames_per_episode=0,
                sound=False,
                color_averaging=False,
            )
        return options

    def make_engine(self) -> _emulator.VectorEngine:
        """The engine, which has the environments and their threads."""
        writes = self._writes
        games = set(self.games)
        compile_game = compiled if self.players == 1 else compiled_for_players
        native = {game: compile_game(game, read_image(find(game, self.rom))) for game in games}
        tables = {game: _gray_of_pairs(game) if self.protocol.pool_rgb else None for game in games}
        seeds = np.random.SeedSequence().generate_state(9 * len(self.games)).reshape(-1, 9).tolist()
        members = [
            filled(
                _emulator.MemberSpec(),
                game=native[game],
                actions=list(map(int, self.actions[index])),
                action_set=list(map(int, self.action_sets[index])),
                mode=self.modes[index],
                difficulty=self.difficulties[index],
                seed=seeds[index],
                gray_of_pairs=tables[game],
            )
            for index, game in enumerate(self.games)
        ]
        threads = filled(
            _emulator.VectorSettings(),
            batch_size=self.batch_size,
            threads=self.num_threads,
            first_core=self.thread_affinity_offset,
            autoreset=_emulator.Autoreset[self.autoreset_mode.name],
        )
        task = task_of(
            self.protocol,
            self.players,
            img_height=self.img_height,
            img_width=self.img_width,
            stack_num=self.stack_num,
        )
        episode = filled_by_name(_emulator.EpisodeSettings(), task)
        observation = filled_by_name(_emulator.ObservationSettings(), task, pixels=self._pixel_format())
        engine = _emulator.VectorEngine(members, episode, observation, threads)
        for index, made in enumerate(writes):
            for write in made:
                engine.add_write(index, write)
        return engine

    def _pixel_format(self) -> _emulator.PixelFormat:
        if self.obs_type == "ram":
            return _emulator.PixelFormat.NONE
        if self.protocol.pool_rgb:
            return _emulator.PixelFormat.GRAY_OF_RGB
        return _emulator.PixelFormat.GRAY if self.grayscale else _emulator.PixelFormat.RGB

    @cached_property
    def _writes(self) -> tuple[list[_emulator.Write], ...]:
        """By environment, the writes of its interventions. Environments of a game share them."""
        made = {game: make_writes(game, items) for game, items in zip(self.games, self.interventions, strict=True)}
        return tuple(made[game] for game in self.games)

    @cached_property
    def action_sets(self) -> tuple[tuple[Action, ...], ...]:
        """By environment, the actions that its game uses."""
        every = self.protocol.full_action_space or self.continuous
        if self.players > 1:
            return tuple(PLAYER_ACTIONS if every else rules_of(game).minimal_actions for game in self.games)
        return tuple(game.legal_actions if every else game.minimal_actions for game in self.games)

    @property
    def _mixed(self) -> bool:
        return len(set(self.action_sets)) > 1

    @property
    def actions(self) -> tuple[tuple[Action, ...], ...]:
        """By environment, the action of each index that a user gives."""
        return (PLAYER_ACTIONS,) * len(self.games) if self.continuous or self._mixed else self.action_sets

    def action_space(self) -> spaces.Space[Any]:
        """The action space of one environment."""
        if self.players > 1:
            return spaces.MultiDiscrete([len(self.actions[0])] * self.players)
        return make_action_space(self.actions[0], self.continuous)

    def batched_action_space(self) -> spaces.Space[Any]:
        """The action space of a batch."""
        single = self.action_space()
        if isinstance(single, spaces.MultiDiscrete):  # which `batch_space` would make a Box
            return spaces.MultiDiscrete(np.tile(single.nvec, (self.batch_size, 1)))
        return batch_space(single, self.batch_size)

    def action_masks(self) -> npt.NDArray[np.bool_] | None:
        """Which actions each game has, (environments, 18) bool; None if all have the same."""
        if self.continuous or not self._mixed:
            return None
        return np.array([[action in actions for action in PLAYER_ACTIONS] for actions in self.action_sets])

    def observation_space(self) -> spaces.Space[Any]:
        """The observation space of one environment."""
        colours = () if self.grayscale else (3,)
        image = spaces.Box(0, 255, (self.stack_num, self.img_height, self.img_width, *colours), np.uint8)
        ram = spaces.Box(0, 255, (128,), np.uint8)
        if self.obs_type == "dict":
            return spaces.Dict({"image": image, "ram": ram})
        return ram if self.obs_type == "ram" else image

    def part_names(self) -> tuple[str, str]:
        """The keys of image and RAM in observations: "" if an observation is no dict, "none" for an absent part."""
        return {"dict": ("image", "ram"), "ram": ("none", "")}.get(self.obs_type, ("", "none"))

    def moves(
        self, actions: Any, rows: int | None = None
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32] | None]:
        """The indices of actions, (rows * players,) int64, and the strengths of paddles, (rows,) float32 or None.

        `rows` is `batch_size` if it is None. Indices are not checked for their range.

        Raises:
            TypeError, ValueError: of the wrong kind or shape.
        """
        if (
            rows is None
            and type(actions) is _ndarray
            and actions.dtype is _INT64
            and actions.shape == self._index_shape
        ):
            return actions, None  # the usual kind, without the checks below: this is done at every step
        array = np.asarray(actions)
        rows = self.batch_size if rows is None else rows
        shape = (rows, 3) if self.continuous else (rows,) if self.players == 1 else (rows, self.players)
        kinds = "f" if self.continuous else "iu"
        if array.dtype.kind not in kinds:
            kind = "floats (radius, angle, fire)" if self.continuous else "integers"
            raise TypeError(f"actions must be {kind} of shape {shape}, got {array.dtype}")
        if array.shape != shape:
            raise ValueError(f"actions must have the shape {shape}, got {array.shape}")
        if self.continuous:
            return self._motions(array)
        return np.ascontiguousarray(array, np.int64).reshape(-1), None

    @cached_property
    def _index_shape(self) -> tuple[int, ...]:
        """Of a batch of actions that are indices, of one player; none has the shape (-1,)."""
        return (-1,) if self.continuous or self.players > 1 else (self.batch_size,)

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
        return joystick_action(radius, angle, fire, self.threshold), radius


_SHAPING = {
    "max_num_frames_per_episode": 108_000,
    "continuous": False,
    "img_height": 84,
    "img_width": 84,
    "grayscale": True,
    "stack_num": 4,
    "frameskip": 4,
    "maxpool": True,
    "noop_max": 30,
    "life_loss_info": False,
    "use_fire_reset": True,
}
"""The options that a preset decides, with their defaults: another value is an error, but for `stack_num`."""

_IMAGE = frozenset(["img_height", "img_width", "grayscale", "stack_num"])
"""Those of them that a user's own `Protocol` leaves open."""


def _check_protocol(given: dict[str, Any]) -> Protocol:
    probability, full = given["repeat_action_probability"], given["full_action_space"]
    clips = check_clip_reward(given["clip_reward"], given["reward_clipping"])
    if probability is not None:
        probability = check_probability("repeat_action_probability", probability)
    if isinstance(given["preset"], Protocol):
        return _check_own_protocol(given)
    if given["preset"] is not None and given["players"] is None:
        _require_defaults(given, {name: _SHAPING[name] for name in _SHAPING if name != "stack_num"})
        from atari.wrappers.presets import preset_protocol  # here, because it imports OpenCV

        return preset_protocol(
            given["preset"],
            episodic_life=given["episodic_life"],
            clip_reward=clips,
            repeat_action_probability=probability,
            full_action_space=full,
        )
    frameskip = check_frameskip(given["frameskip"])
    limit = given["max_num_frames_per_episode"]
    return Protocol(
        repeat_action_probability=probability or 0.0,
        full_action_space=bool(full),
        frame_skip=frameskip if isinstance(frameskip, tuple) else (frameskip, frameskip + 1),
        noops=(0, max(check_integer("noop_max", given["noop_max"], 0, 1_000_000), 1) - 1),
        fire="before_noops" if given["use_fire_reset"] else "never",
        episodic_life=bool(given["episodic_life"]),
        life_loss_info=bool(given["life_loss_info"]),
        clip_reward=clips is None or bool(clips),
        max_frames=None if limit is None else check_integer("max_num_frames_per_episode", limit, 1, NO_LIMIT),
        max_pool=bool(given["maxpool"]),
        end_frames="gymnasium" if given["players"] is None else "last",
        padding="zero" if given["preset"] is None else "reset",
    )


def _check_own_protocol(given: dict[str, Any]) -> Protocol:
    """A protocol that the user made.

    Raises:
        TypeError, ValueError: options that the protocol decides are given too, or one of its values is out of range.
    """
    protocol: Protocol = given["preset"]
    decided = {name: default for name, default in _SHAPING.items() if name not in _IMAGE}
    undecided = ("repeat_action_probability", "full_action_space", "episodic_life", "reward_clipping", "clip_reward")
    _require_defaults(given, {**decided, **dict.fromkeys(undecided)})
    check_probability("repeat_action_probability", protocol.repeat_action_probability)
    check_frameskip(protocol.frame_skip)
    low, high = protocol.noops
    check_integer("noops", low, 0, check_integer("noops", high, 0, 1_000_000))
    check_integer("max_num_frames_per_episode", protocol.max_num_frames_per_episode, 0, NO_LIMIT)
    if protocol.max_frames is not None:
        check_integer("max_frames", protocol.max_frames, 1, NO_LIMIT)
    for name in ("order", "fire", "on_reset", "end_frames", "padding"):
        check_name(name, getattr(protocol, name), get_args(Protocol.__annotations__[name]))
    if protocol.pool_rgb and not given["grayscale"]:
        raise ValueError("with pool_rgb the observations are gray; leave grayscale=False out")
    return protocol


def _require_defaults(given: dict[str, Any], defaults: dict[str, Any]) -> None:
    for name, default in defaults.items():
        if given[name] != default:
            raise ValueError(f"preset={given['preset']!r} decides about {name}; leave {name}={given[name]!r} out")


def _check_third_actions(action_sets: tuple[tuple[Action, ...], ...], games: tuple[Game, ...]) -> None:
    for actions, game in zip(action_sets, games, strict=True):
        if Action.FIRE in actions and len(actions) < 3:
            raise ValueError(
                f"this preset begins with the third action, and {game.id} has only {len(actions)}; "
                "use full_action_space=True"
            )


def _gray_of_pairs(game: Game) -> _emulator.GrayOfPairs:
    from atari.wrappers._rgb_pool import gray_of_pairs  # here, because it imports OpenCV

    return _emulator.GrayOfPairs(gray_of_pairs(game.screen.format).tobytes())


def _check_games(game: Any, num_envs: Any, several_players: bool) -> tuple[Game, ...]:
    many = isinstance(game, Sequence) and not isinstance(game, str)
    if num_envs is None and not many:
        raise TypeError("num_envs is needed: how many environments of the game to make")
    if many and len(game) == 0:
        raise ValueError("game must name at least one game")
    count = len(game) if num_envs is None else check_integer("num_envs", num_envs, 1, 1_000_000)
    find_game = catalog.resolve if several_players else catalog.find
    if not many:
        return (find_game(game),) * count
    if count != len(game):
        raise ValueError(f"there must be a game for each of the {count} environments, got {len(game)}")
    return tuple(find_game(one) for one in game)


def _spread(name: str, value: Any, count: int) -> tuple[int | None, ...]:
    """One value for each environment."""
    values = [value] * count if value is None or isinstance(value, (int, np.integer)) else value
    if not isinstance(values, (Sequence, np.ndarray)) or isinstance(values, str):
        raise TypeError(f"{name} must be an integer, None, or a sequence of these, got {value!r}")
    if len(values) != count:
        raise ValueError(f"there must be a {name} for each of the {count} environments, got {len(values)}")
    try:
        return tuple(None if one is None else operator.index(one) for one in values)
    except TypeError:
        raise TypeError(f"{name} must be an integer, None, or a sequence of these, got {value!r}") from None


def _check_obs_type(obs_type: Any, grayscale: bool) -> tuple[str, bool]:
    if obs_type is None:
        return "grayscale" if grayscale else "rgb", grayscale
    return check_name("obs_type", obs_type, ("grayscale", "rgb", "ram", "dict")), grayscale and obs_type != "rgb"


def _check_autoreset(mode: Any) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        modes = ", ".join(repr(one.value) for one in AutoresetMode)
        raise ValueError(f"autoreset_mode must be an AutoresetMode or one of {modes}, got {mode!r}") from None


def _cores() -> int:
    """The processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
