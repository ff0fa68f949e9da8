"""`AtariEnv`: one Atari 2600 game as a Gymnasium environment.

Options, defaults, observations, rewards and random streams are those of ale-py's environment of the same name
(Machado et al. 2018, "Revisiting the Arcade Learning Environment"); equality to the byte is a test.
"""

import inspect
from collections.abc import Mapping, Sequence
from enum import Enum
from os import PathLike
from typing import Any, Literal, get_args

import gymnasium
import numpy as np
from gymnasium import spaces
from typing_extensions import Unpack

from atari.base.notebook import picture
from atari.base.png import png
from atari.base.validation import check_action, check_name
from atari.cores import CORES, NativeCore, PlainCore
from atari.cores.ale_actions import Action as AleAction
from atari.cores.ale_interface import AleInterface
from atari.cores.options import check_difficulty, check_mode
from atari.env.driver import Driver
from atari.env.rendering import Window
from atari.env.settings import observation_space, pixel_format
from atari.env.state import EnvState
from atari.games.actions import PLAYER_ACTIONS, Action, make_action_space
from atari.games.interventions import Intervention
from atari.roms import find
from atari.task import Task
from atari.task.fields import UNSET, AddedOptions, Interventions
from atari.task.observation_kinds import KINDS
from atari.task.task import GameLike, look_up

ObsType = Literal["rgb", "grayscale", "ram"]
RenderMode = Literal["human", "rgb_array", "rgb_array_list"]


class AtariEnv(EnvState):
    """A game of the Atari 2600.

    `game` is an environment ID or an `atari.Task`, which decide the whole task, or a game's name. A name has ale-py's
    defaults: those of ALE's v5 IDs without a limit of frames. `task` is the result. `AtariEnv` refuses options that
    wrappers play, such as `noops`: `atari.make` adds the wrappers.

    Args:
        game: an ID, a game's name, the path of a game file of your own, a `Game`, or a `Task`.
        render_mode: "human" shows a window (extra `play`), "rgb_array" returns the screen from `render`,
            "rgb_array_list" the screens since the last `render`, one a step.
        core: the emulator: "native" (ours), "plain" (our reference core, slower) or "ale" (ale-py); all give the same
            bytes.
        rom: path of the ROM file; None searches (see `atari.roms`).
        **options: the other options, also by position in ale-py's order, are fields of `atari.Task`, which describes
            them. Observations are uint8: "rgb" (height, 160, 3), "grayscale" (height, 160), "ram" (128,); with
            `sound_obs`, {"image": ..., "sound": (512,)}. `full_action_space` is another name of `actions`.

    Raises:
        TypeError: there is no such option; the message suggests the nearest.
        TypeError, ValueError: an option is of the wrong kind or not offered by the game.
        FileNotFoundError: no ROM file of the game was found.
        gymnasium.error.DependencyNotInstalled: render_mode "human" without pygame-ce.
        gymnasium.error.Error: render_mode "human" where there is no display.

    `reset` and `step` return, with `info`: `lives`, `episode_frame_number` and `frame_number` (emulated frames since
    the last seeded reset); after a seeded `reset` also `seeds`, the two words drawn from the seed.
    Rewards are floats, the sum over the step's frames, not clipped.

    Example:
        >>> import atari
        >>> env = atari.AtariEnv("breakout", obs_type="ram", frameskip=1)
        >>> observation, info = env.reset(seed=0)
        >>> observation.shape, info["lives"], env.get_action_meanings()
        ((128,), 5, ['NOOP', 'FIRE', 'RIGHT', 'LEFT'])
        >>> observation, reward, terminated, truncated, info = env.step(1)
        >>> info["episode_frame_number"]
        1
    """

    metadata: dict[str, Any] = {"render_modes": list(get_args(RenderMode)), "render_fps": 15}  # noqa: RUF012
    """Gymnasium's facts about the class. Each environment has its own copy with its rounded rate of steps."""

    interventions: tuple[Intervention, ...]
    """The interventions of the game: the option of this name."""

    def __init__(
        self,
        game: GameLike,
        mode: int | None = UNSET,
        difficulty: int | None = UNSET,
        obs_type: ObsType = UNSET,
        frameskip: int | tuple[int, int] = UNSET,
        repeat_action_probability: float = UNSET,
        full_action_space: bool = UNSET,
        continuous: bool = UNSET,
        continuous_action_threshold: float = UNSET,
        max_num_frames_per_episode: int | None = UNSET,
        render_mode: RenderMode | None = None,
        sound_obs: bool = UNSET,
        *,
        core: str = "native",
        rom: str | PathLike[str] | None = None,
        interventions: Interventions = UNSET,
        **options: Unpack[AddedOptions],
    ) -> None:
        named = {name: value for name, value in locals().items() if name in ALE_OPTIONS and value is not UNSET}
        task = look_up(game).task(None, {**named, **options}, _BASE, owner="AtariEnv", others=_OTHERS)
        _require_no_wrappers(task)
        check_name("core", core, CORES)
        if render_mode is not None:
            check_name("render_mode", render_mode, get_args(RenderMode))
        self._begin(task, render_mode, core, rom)
        # ale-py's environment begins with these two; an override may prepare the game.
        if type(self).seed_game is not AtariEnv.seed_game:
            self.seed_game()
        if type(self).load_game is not AtariEnv.load_game:
            self.load_game()

    def __init_subclass__(cls, **arguments: Any) -> None:
        """Make `observe` and `_get_obs`, two names of one method, the one that the subclass defines."""
        super().__init_subclass__(**arguments)
        for name, other in (("observe", "_get_obs"), ("_get_obs", "observe")):
            if name in vars(cls) and other not in vars(cls):
                setattr(cls, other, vars(cls)[name])

    def _begin(self, task: Task, render_mode: RenderMode | None, core: str, rom: str | PathLike[str] | None) -> None:
        self._made_with = {"task": task, "render_mode": render_mode, "core": core, "rom": rom}
        self._task = self.whole_task = task
        self.game = task.definition
        self.interventions = task.interventions
        self.render_mode = render_mode
        self.sound_obs = task.sound_obs
        self.driver = Driver(task, core, rom)
        self._ale: Any = AleInterface(self.driver)
        self._own_ale = self._ale
        self._np_random_seed = -1
        self._obs_type, self._frameskip = task.obs_type, task.frameskip  # `step` reads them
        kind = type(self)
        own_results = kind._get_obs is not kind.observe or kind.observe is not AtariEnv.observe
        self._calls_methods = self.sound_obs or own_results or kind._get_info is not AtariEnv._get_info
        self.action_space = make_action_space(task.action_set, self.continuous)
        seen, sound = observation_space(task), spaces.Box(0, 255, (512,), np.uint8)
        self.observation_space = spaces.Dict({"image": seen, "sound": sound}) if self.sound_obs else seen
        self.metadata = {**self.metadata, "render_fps": max(1, round(self._steps_per_second()))}
        self._window = self._make_window()
        self._frames = []

    def ale_options(self) -> dict[str, Any]:
        """The task without wrappers, as options by ale-py's names."""
        task = self._as_set(self._task)
        names = ("obs_type", "frameskip", "repeat_action_probability", "continuous", "continuous_action_threshold")
        return {
            "mode": task.set_mode,
            "difficulty": task.set_difficulty,
            **{name: getattr(task, name) for name in (*names, "max_num_frames_per_episode", "sound_obs")},
            "full_action_space": task.actions == "full",
            "interventions": [one.definition() for one in task.interventions] or None,
        }

    @property
    def ale(self) -> Any:
        """The core under the method names of ale-py's `ALEInterface`, which many wrappers expect.

        As in ale-py, another object with these methods can be assigned. `reset`, `step` and `render` then play and read
        through it (`act`, `getScreenRGB`, `lives` and the like), until the first object is assigned again.
        """
        return self._ale

    @ale.setter
    def ale(self, ale: Any) -> None:
        self.driver.play_through(None if ale is self._own_ale else ale)
        self._ale = ale

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start a new episode; with `seed`, also restart all generators. Reopens after `close`.

        Args:
            seed: an integer of 0 or more.
            options: "new_game", which wrappers that continue a game take; a reset of `AtariEnv` always begins one.
                `atari.wrappers.NoopReset` takes "noops", and `FireReset` "fire".

        Raises:
            gymnasium.error.Error: the seed is no integer of 0 or more.
            TypeError: another option is given, which would have no effect; nothing is reset.
        """
        check_reset_options(options)
        super().reset(seed=seed)
        self.reopen()
        seeds: dict[str, Any] = {}
        if seed is not None:
            seeds = {"seeds": self.seed_game(seed)}
            self.load_game()
        self.driver.reset()
        self._frames.clear()
        self.show()
        return self._get_obs(), {**self._get_info(), **seeds}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play `frameskip` frames.

        Args:
            action: index into the action set, or with `continuous` a float array (radius, angle, fire).

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            TypeError, ValueError: the action is not in the action space.
        """
        driver = self.driver
        number, strength = driver.ale_action(action)
        frames = self._frameskip if isinstance(self._frameskip, int) else driver.draw(*self._frameskip)
        if self._plays_in_one_call():
            results = driver.play_step(number, strength, _PIXELS[self._obs_type], frames=frames)
            self.show()
            return results
        reward = driver.play_frames(number, strength, frames=frames)
        self.show()
        core, over = driver.core, driver.phase != "playing"
        return self._get_obs(), reward, over and core.game_over, over and core.truncated, self._get_info()

    def observe(self) -> Any:
        """The observation of the present frame, a new array."""
        observed = self.driver.observed
        image = getattr(observed, KINDS[self._obs_type].method)()
        return {"image": image, "sound": observed.audio()} if self.sound_obs else image

    # ale-py's names, which programs read, set and override

    _get_obs = observe

    def _get_info(self) -> dict[str, Any]:
        return self.driver.info()

    def _plays_in_one_call(self) -> bool:
        """Whether a step need call no method of a subclass, of this object, of its core or of an observer."""
        driver, own = self.driver, vars(self)
        if self._calls_methods or not driver.plays_several:
            return False
        if "_get_obs" in own or "observe" in own or "_get_info" in own:
            return False
        core = driver.core
        return type(core) in _IN_ONE_CALL and "act" not in vars(core)

    @property
    def has_own_step(self) -> bool:
        """Whether a subclass changes `step`, or the information that it returns."""
        kind = type(self)
        return kind.step is not AtariEnv.step or kind._get_info is not AtariEnv._get_info

    @property
    def continuous(self) -> bool:
        """Whether actions are continuous."""
        return self._task.continuous

    @property
    def continuous_action_threshold(self) -> float:
        """The least deflection of the stick, or pressure on fire, that counts in a continuous action."""
        return self._task.continuous_action_threshold

    @property
    def _action_set(self) -> list[AleAction]:
        return [AleAction(action) for action in self.driver.actions]

    @_action_set.setter
    def _action_set(self, actions: Sequence[Any]) -> None:
        numbers = (action.value if isinstance(action, Enum) else action for action in actions)
        self.driver.actions = tuple(Action(check_action(number)) for number in numbers)

    @property
    def _game(self) -> str:
        return self.game.id

    @property
    def _game_mode(self) -> int | None:
        return self.ale_settings.choices.get("mode", self._task.set_mode)

    @_game_mode.setter
    def _game_mode(self, mode: int | None) -> None:
        self.ale_settings.choose("mode", None if mode is None else check_mode(self.game, mode))

    @property
    def _game_difficulty(self) -> int | None:
        return self.ale_settings.choices.get("difficulty", self._task.set_difficulty)

    @_game_difficulty.setter
    def _game_difficulty(self, difficulty: int | None) -> None:
        self.ale_settings.choose("difficulty", None if difficulty is None else check_difficulty(self.game, difficulty))

    def _repr_html_(self) -> str | None:
        """The screen, for a notebook; None after `close`."""
        if self.driver.closed:
            return None
        caption = f"{self.game.title}: not reset yet"
        if self.driver.phase != "new":
            caption = f"{self.game.title}: frame {self.core.episode_frame_number:,}"
            caption += f", score {self.driver.played.score:,.0f}"
            if self.game.rules and self.game.rules.lives_initial:
                caption += f", lives {self.core.lives}"
        return picture(png(self.core.screen_rgb()), caption, self.game.screen.shape)

    def render(self) -> Any:
        """The screen, (height, 160, 3) uint8, a list of such screens, or None, according to the render mode.

        Raises:
            gymnasium.error.Error: there is no render mode.
        """
        if self.render_mode == "rgb_array":
            return self.core.screen_rgb()
        if self.render_mode == "rgb_array_list":
            frames, self._frames = self._frames, []
            return frames
        if self.render_mode == "human":
            return None  # step and reset have already shown the screen
        raise gymnasium.error.Error(
            "render() needs a render mode; make the environment with render_mode='rgb_array' or 'human'"
        )

    @property
    def recent_screens(self) -> tuple[Any, ...]:
        """The screens since the last `render`, with the render mode "rgb_array_list"; none otherwise."""
        return tuple(self._frames)

    def reopen(self) -> bool:
        """Open the emulator and the window again after `close`; returns whether they were closed."""
        closed = self.driver.closed
        if closed:
            self.driver.reopen()
            self._window = self._make_window()
        return closed

    def close(self) -> None:
        """Release the emulator and the window. As in ale-py, a later `reset` opens them again."""
        if self._window is not None:
            self._window.close()
            self._window = None
        self.driver.close()

    def seed_game(self, seed: int | None = None) -> tuple[np.uint32, np.uint32]:
        """Seed all generators, the emulator's from the next `load_game` on, like ale-py; see `Driver.seed_game`."""
        words = self.driver.seed_game(seed)
        if self._ale is not self._own_ale:
            self._ale.setInt("random_seed", self.ale_settings.get("random_seed", int))
        return words

    def load_game(self) -> None:
        """Load the game again, like ale-py; see `AleGame.load_game`."""
        if self._ale is self._own_ale:
            self.driver.load_game()
        else:
            self._ale.loadROM(find(self.game, self.driver.rom))

    def get_action_meanings(self) -> list[str]:
        """The names of the actions, in the order of the action space."""
        return [action.name for action in self.driver.actions]

    @staticmethod
    def map_action_idx(left_center_right: int, down_center_up: int, fire: bool) -> AleAction:
        """The action for a position of the stick and the fire button, like ale-py's method of this name.

        Args:
            left_center_right, down_center_up: -1, 0 or 1.
            fire: whether the button is pressed.

        Raises:
            LookupError: there is no such position.
        """
        for action in PLAYER_ACTIONS:
            if (action.horizontal, action.vertical, action.fire) == (left_center_right, down_center_up, fire):
                return AleAction(action)
        raise LookupError(f"positions are -1, 0 and 1, got {left_center_right!r}, {down_center_up!r} and fire {fire!r}")

    def get_keys_to_action(self) -> dict[tuple[str, ...], int]:
        """The action of each key combination, for `gymnasium.utils.play`: w a s d, space for fire, e for none.

        Raises:
            AttributeError: actions are continuous.
        """
        if self.continuous:
            raise AttributeError(
                "`get_keys_to_action` can't be provided for this Atari environment as `continuous=True`. "
                "Keys stand for discrete actions"
            )
        return {_keys(action): index for index, action in enumerate(self.driver.actions)}

    def _make_window(self) -> Window | None:
        return Window(self.game, self._steps_per_second()) if self.render_mode == "human" else None

    def _steps_per_second(self) -> float:
        """Steps in a second of play: the frame rate of a video with one frame for each step."""
        return 2 * self.game.screen.frame_rate / (sum(self._task.frames) - 1)

    def show(self) -> None:
        """Show the present screen in the window, or keep it for `render`, as the render mode says."""
        if self._window is not None:
            self._window.show(self.core.screen_rgb())
        elif self.render_mode == "rgb_array_list":
            self._frames.append(self.core.screen_rgb())


_PIXELS = {name: pixel_format(kind) for name, kind in KINDS.items() if kind.method}
_IN_ONE_CALL = (NativeCore, PlainCore)
"""The cores that play a step by one call; a subclass may have methods of its own."""

_BASE = {"max_num_frames_per_episode": None}
"""The fields in which a game's name differs from its v5 ID, as in ale-py."""

_OTHERS = ("render_mode", "core", "rom")
"""The options that are no fields of a task."""

ALE_OPTIONS = frozenset(inspect.signature(AtariEnv.__init__).parameters) - {"self", "game", "options", *_OTHERS}
"""The options of an `AtariEnv` by ale-py's names, and `interventions`."""


def options_of_reset(options: Any) -> dict[str, Any]:
    """A copy of the options of a reset.

    Raises:
        TypeError: `options` is no dict.
    """
    if options is not None and not isinstance(options, Mapping):
        raise TypeError(f"the options of a reset are a dict, got {options!r}")
    return dict(options or {})


def check_reset_options(options: Any) -> None:
    """Refuse options of a reset that no wrapper has taken and that would have no effect.

    Raises:
        TypeError: there is such an option, or `options` is no dict.
    """
    for name, value in options_of_reset(options).items():
        if name != "new_game" and not (name == "fire" and not value):
            raise TypeError(
                f"reset has no option {name!r} here; it has 'new_game', with NoopReset 'noops', with FireReset 'fire', "
                "and AtariVectorEnv has 'reset_mask'"
            )


def _require_no_wrappers(task: Task) -> None:
    if task.players > 1:
        raise ValueError(
            f"AtariEnv is for one player, got players={task.players}; "
            f"atari.multiplayer.parallel_env({task.game!r}) and AtariVectorEnv are for more"
        )
    needed = task.fields_of_wrappers() + ["max_episode_steps"] * (task.max_episode_steps is not None)
    if needed:
        field = needed[0]
        raise ValueError(
            f"AtariEnv plays without wrappers, and {field}={getattr(task, field)!r} needs them; use atari.make, which "
            "adds them"
        )


def _keys(action: Action) -> tuple[str, ...]:
    keys = ({1: "w", -1: "s"}.get(action.vertical), {1: "d", -1: "a"}.get(action.horizontal))
    return tuple(key for key in (*keys, " " if action.fire else None) if key) or ("e",)
