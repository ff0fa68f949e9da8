"""`AtariEnv`: one Atari 2600 game as a Gymnasium environment.

Options, defaults, observations, rewards and random streams are those of ale-py's environment of the same name
(Machado et al. 2018, "Revisiting the Arcade Learning Environment"); equality to the byte is a test.
"""

import inspect
from contextlib import suppress
from os import PathLike
from typing import Any, Literal, Protocol, get_args

import gymnasium
import numpy as np
from gymnasium import logger, spaces
from typing_extensions import Unpack

from atari.actions import PLAYER_ACTIONS, Action, in_continuous_space, joystick_action, make_action_space
from atari.cores import CORES, Core, NativeCore
from atari.cores.ale_interface import AleInterface, AleSettings
from atari.env_state import EnvState, Played, slots
from atari.games.interventions import Intervention
from atari.notebook import picture, png
from atari.rendering import Window
from atari.task import Task
from atari.task.fields import UNSET
from atari.task.options import AddedOptions, Interventions
from atari.task.resolution import GameLike, resolve_task
from atari.validation import check_action_index, check_name

ObsType = Literal["rgb", "grayscale", "ram"]
RenderMode = Literal["human", "rgb_array", "rgb_array_list"]


class FrameObserver(Protocol):
    """Receives every emulated frame, those inside a frame skip too; see `AtariEnv.observers`."""

    def game_begun(self) -> None:
        """The emulator was reset."""

    def frame_played(self, action: int, reward: int) -> None:
        """The core has played a frame with this ALE action. Must not raise."""


class AtariEnv(EnvState):
    """A game of the Atari 2600.

    `game` says what is played: an environment ID or an `atari.Task` all of it; a name alone has ale-py's defaults,
    those of ALE's v5 IDs without a limit of frames. `task` has the result. Options of a task that wrappers play, such
    as `noops`, are refused: `atari.make` adds the wrappers.

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
    """Gymnasium's facts about the class. Each environment has its own copy, with the rate of its steps, rounded."""

    observers: list[FrameObserver]
    """The receivers of every frame, such as recorders. An observer may read the core, but not change it. Copies of the
    environment have no observers."""

    interventions: tuple[Intervention, ...]
    """The interventions of the game, of the option of this name."""

    _closed_state: Any = None
    """The state at `close`, from which `reset` continues."""

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
        others = ("render_mode", "core", "rom")
        task = resolve_task(game, None, {**named, **options}, base=_BASE, owner="AtariEnv", others=others)
        _require_plain(task)
        check_name("core", core, CORES)
        if render_mode is not None:
            check_name("render_mode", render_mode, get_args(RenderMode))
        self._begin(task, render_mode, core, rom)

    def _begin(self, task: Task, render_mode: RenderMode | None, core: str, rom: str | PathLike[str] | None) -> None:
        """Make the core and the spaces."""
        self._made_with = {"task": task, "render_mode": render_mode, "core": core, "rom": rom}
        self._task = self.whole_task = task
        self.game = task.definition
        self.interventions = task.interventions
        self.render_mode = render_mode
        self._threshold = np.float32(task.continuous_action_threshold)
        self.continuous, self.sound_obs = task.continuous, task.sound_obs
        self.continuous_action_threshold = task.continuous_action_threshold
        self.ale_settings = AleSettings(
            repeat_action_probability=task.repeat_action_probability,
            max_num_frames_per_episode=task.max_num_frames_per_episode or 0,
            sound_obs=task.sound_obs,
        )
        self._core_options = self.ale_settings.core_options()
        self._ale_random = None
        self.seed_game()
        self._np_random_seed = -1
        self.core = self._make_core()
        self.observers = []
        self._action_set: tuple[Action, ...] = task.action_set
        self._obs_type, self._frameskip = task.obs_type, task.frameskip  # read at every step
        self.action_space = make_action_space(self._action_set, self.continuous)
        self.observation_space = self._make_observation_space()
        self.metadata = {**self.metadata, "render_fps": max(1, round(self._steps_per_second()))}
        self._window = self._make_window()
        self._frames = []
        self._phase = "new"
        self._game = Played()
        self._ended_game = None
        self._restored = False
        self._instead: str | None = None  # an action that replaces any, see `step_named` of the wrappers

    def ale_options(self) -> dict[str, Any]:
        """What this plays without wrappers, as options by ale-py's names."""
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
    def ale(self) -> AleInterface:
        """The core under the method names of ale-py's `ALEInterface`, which many wrappers expect."""
        return AleInterface(self)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Start a new episode; with `seed`, also restart all generators. `options` are ignored. Reopens after `close`.

        Raises:
            gymnasium.error.Error: the seed is no integer of 0 or more.
        """
        super().reset(seed=seed)
        if self._closed_state is not None:
            self._reopen()
        seeds: dict[str, Any] = {}
        if seed is not None:
            seeds = {"seeds": self.seed_game(seed)}
            self.load_game()
        self.core.reset()
        self._phase = "playing"
        self._game = Played(first_frame=self.core.episode_frame_number)
        self._restored = False
        self._frames.clear()
        for observer in self.observers:
            observer.game_begun()
        self._show()
        return self._get_obs(), {**self._info(), **seeds}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play `frameskip` frames.

        Args:
            action: index into the action set, or with `continuous` a float array (radius, angle, fire).

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            TypeError, ValueError: the action is not in the action space.
        """
        number, strength = self._ale_action(action)
        reward = self.play_frames(number, self._draw_frameskip(), strength)
        self._show()
        return self._get_obs(), reward, self.core.game_over, self.core.truncated, self._info()

    def play_frames(self, action: int, frames: int, strength: float = 1.0) -> float:
        """Play frames with an ALE action number and return the reward, without making an observation.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            TypeError, ValueError: no ALE action (0..17), or a strength that is not finite.
        """
        if self._phase != "playing":
            self._check_phase()
        act = self._act_observed if self.observers else self.core.act
        reward = 0.0
        for _ in range(frames):
            reward += act(action, strength)
        self._count(reward)
        return reward

    def play_until(self, action: int, frames: int, strength: float = 1.0) -> tuple[float, int]:
        """Play up to `frames` frames, and return the reward and how many were played.

        The last one ends the game, or changes the number of lives, or is the last of `frames`; cores that play single
        frames alone, and observers, end it after one. Wrappers that read only some of the frames
        (`atari.wrappers.DqnPreprocessing`) call it instead of `step`.

        Raises:
            gymnasium.error.ResetNeeded, TypeError, ValueError: as `play_frames`.
        """
        if self._phase != "playing":
            self._check_phase()
        core = self.core
        if self.observers or not isinstance(core, NativeCore):
            return self.play_frames(action, 1, strength), 1
        reward, played = core.act_until(action, frames, strength)
        self._count(reward)
        return float(reward), played

    def _count(self, reward: float) -> None:
        """Count a reward, and find out whether the game has ended."""
        if reward:
            self._game.score += reward
            self._game.rewards += 1
        if (self.core.game_over or self.core.truncated) and self._phase == "playing":
            self._phase = "over"
            self._ended_game = self._game.statistics(self.core)

    def make_sound(self) -> None:
        """Switch the emulator's sound on; observations stay what they are.

        `core` becomes another object, in the same state.
        """
        self.core = self.core.with_sound()

    def _repr_html_(self) -> str | None:
        """The screen, for a notebook; None after `close`."""
        if self._closed_state is not None:
            return None
        height, width = self.game.screen.shape
        caption = f"{self.game.title}: not reset yet"
        if self._phase != "new":
            frame, lives = self.core.episode_frame_number, self.core.lives
            caption = f"{self.game.title}: frame {frame:,}, score {self._game.score:,.0f}, lives {lives}"
        return picture(png(self.core.screen_rgb()), caption, width=2 * width, height=height)

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

    def close(self) -> None:
        """Release the emulator and the window. As in ale-py, `reset` goes on afterwards, as without `close`."""
        if self._window is not None:
            self._window.close()
            self._window = None
        if self._closed_state is None:
            with suppress(RuntimeError):  # the core itself was closed
                self._closed_state = self.core.clone_state(include_rng=True)
        self.core.close()

    def seed_game(self, seed: int | None = None) -> tuple[np.uint32, np.uint32]:
        """Seed `np_random`, and the emulator from the next `load_game` on; None draws a new seed.

        Returns:
            The two words drawn from the seed: of `np_random`, and of the emulator.

        Raises:
            TypeError, ValueError: the seed is no integer of 0 or more.
        """
        words = np.random.SeedSequence(seed).generate_state(2)
        if self._ale_random is not None:
            words[1] = self._ale_random.seed(seed)
        self._np_random = np.random.Generator(np.random.PCG64(np.random.SeedSequence(int(words[0]))))
        self.ale_settings.set_seed(int(words[1]))
        return words[0], words[1]

    def _draw(self, low: int, high: int) -> int:
        """A number within low..high-1 from the generator of episodes, which draws no-ops and frame skips."""
        if self._ale_random is None:
            return int(self.np_random.integers(low, high))
        return low + self._ale_random.below(high - low)

    def load_game(self) -> None:
        """Load the game again: with the seed of `seed_game`, what was set by `ale`, and the environment's mode.

        Raises:
            RuntimeError: a setting was changed by `ale` while a replay is recorded.
        """
        if self.ale_settings.stale:
            self._apply_settings()
        self.core.seed(self.ale_settings.seed())

    def get_action_meanings(self) -> list[str]:
        """The names of the actions, in the order of the action space."""
        return [action.name for action in self._action_set]

    @staticmethod
    def map_action_idx(left_center_right: int, down_center_up: int, fire: bool) -> Action:
        """The action of a position of the stick and the fire button, as ale-py's method of this name.

        Args:
            left_center_right, down_center_up: -1, 0 or 1.
            fire: whether the button is pressed.

        Raises:
            LookupError: there is no such position.
        """
        for action in PLAYER_ACTIONS:
            if (action.horizontal, action.vertical, action.fire) == (left_center_right, down_center_up, fire):
                return action
        raise LookupError(f"positions are -1, 0 and 1, got {left_center_right!r}, {down_center_up!r} and fire {fire!r}")

    def get_keys_to_action(self) -> dict[tuple[str, ...], int]:
        """The action of each key combination, for `gymnasium.utils.play`: w a s d, space for fire, e for none.

        Raises:
            AttributeError: actions are continuous.
        """
        if self.continuous:
            raise AttributeError("keys stand for discrete actions; this environment was made with continuous=True")
        return {_keys(action): index for index, action in enumerate(self._action_set)}

    def _make_core(self) -> Core:
        return CORES[self._made_with["core"]](
            self.game,
            seed=self.ale_settings.seed(),
            mode=self._task.set_mode,
            difficulty=self._task.set_difficulty,
            rom=self._made_with["rom"],
            interventions=self.interventions,
            **self._core_options,
        )

    def _replace_core(self) -> None:
        if type(self.core) is not CORES[self._made_with["core"]]:
            raise RuntimeError("a replay of this environment is being recorded; close the recorder first")
        self.core.close()
        self.core = self._make_core()

    def _apply_settings(self) -> None:
        """Apply what was set by `ale`, and the environment's mode and difficulty."""
        options, before = self.ale_settings.core_options(), self._core_options
        difficulty = self._task.difficulty
        if options != before or difficulty not in self.game.difficulties:  # backgammon's default is none of its own
            self._core_options = options
            added = slots(self.core)
            state = self.core.save() if added else None  # type: ignore[attr-defined]  # with which writes are done
            try:
                self._replace_core()
            except RuntimeError:
                self._core_options = before
                raise
            if added:
                self.core.writes = added  # type: ignore[attr-defined]
                self.core.load(state)  # type: ignore[attr-defined]
        else:
            self.core.set_mode(self._task.mode)  # type: ignore[arg-type]  # a task has found it
            self.core.set_difficulty(difficulty)
        self.ale_settings.stale = False

    def _make_window(self) -> Window | None:
        return Window(self.game, self._steps_per_second()) if self.render_mode == "human" else None

    def _reopen(self) -> None:
        """Continue after `close`."""
        sound = self.core.sound
        self._replace_core()
        if sound:
            self.make_sound()
        self.core.restore_state(self._closed_state)
        self._closed_state = None
        self._window = self._make_window()

    def _make_observation_space(self) -> spaces.Space[Any]:
        rows, columns = self.game.screen.shape
        shape = {"rgb": (rows, columns, 3), "grayscale": (rows, columns), "ram": (128,)}[self._obs_type]
        image = spaces.Box(0, 255, shape, np.uint8)
        if not self.sound_obs:
            return image
        return spaces.Dict({"image": image, "sound": spaces.Box(0, 255, (512,), np.uint8)})

    def _steps_per_second(self) -> float:
        """Steps in a second of play, so that a video of one frame a step has the right speed."""
        return 2 * self.game.screen.frame_rate / (sum(self._task.frames) - 1)

    def _draw_frameskip(self) -> int:
        if isinstance(self._frameskip, int):
            return self._frameskip
        return self._draw(*self._frameskip)

    def _ale_action(self, action: Any) -> tuple[int, float]:
        """The ALE action number and the strength of an action of the action space."""
        if self._instead is not None:
            return int(Action[self._instead]), 1.0
        if self.continuous:
            return self._continuous_action(action)
        index = check_action_index(action, len(self._action_set), self.game.id)
        return int(self._action_set[index]), 1.0

    def _continuous_action(self, action: Any) -> tuple[int, float]:
        """The ALE action and the strength of (radius, angle, fire), computed in float32 as in CALE."""
        try:
            with np.errstate(over="ignore"):
                motion = np.asarray(action, dtype=np.float32)
        except (TypeError, ValueError):
            motion = None
        if motion is None or motion.shape != (3,):
            raise TypeError(f"a continuous action is three floats (radius, angle, fire), got {action!r}")
        radius, angle, fire = motion
        if not in_continuous_space(radius, angle, fire):
            raise ValueError(
                f"a continuous action is radius 0..1, angle -pi..pi, fire 0..1, got ({radius}, {angle}, {fire})"
            )
        return int(joystick_action(radius, angle, fire, self._threshold)), float(radius)

    def _get_obs(self) -> Any:
        if self._obs_type == "rgb":
            image = self.core.screen_rgb()
        elif self._obs_type == "ram":
            image = self.core.ram()
        else:
            image = self.core.screen_grayscale()
        return {"image": image, "sound": self.core.audio()} if self.sound_obs else image

    def _info(self) -> dict[str, Any]:
        core = self.core
        return {
            "lives": core.lives,
            "episode_frame_number": core.episode_frame_number,
            "frame_number": core.frame_number,
        }

    def _act_observed(self, action: int, strength: float) -> int:
        before = self.core.frame_number
        reward = self.core.act(action, strength)
        if self.core.frame_number != before:  # after the end of a game, `act` plays no frame
            for observer in self.observers:
                observer.frame_played(action, reward)
        return reward

    def _show(self) -> None:
        if self._window is not None:
            self._window.show(self.core.screen_rgb())
        elif self.render_mode == "rgb_array_list":
            self._frames.append(self.core.screen_rgb())

    def _check_phase(self) -> None:
        """Refuse a step before the first reset, and warn once about a step after the end."""
        if self._phase == "new":
            raise gymnasium.error.ResetNeeded("call env.reset() before the first env.step()")
        if not (self.core.game_over or self.core.truncated):
            self._phase = "playing"  # it was reset through `ale` or `core`
        elif self._phase == "over":
            self._phase = "warned"
            logger.warn("env.step() was called after the episode had ended; nothing happens until env.reset()")


_BASE = {"max_num_frames_per_episode": None}
"""What a game's name alone plays other than ALE's v5, as in ale-py."""

ALE_OPTIONS = frozenset(inspect.signature(AtariEnv.__init__).parameters) - {
    "self",
    "game",
    "render_mode",
    "core",
    "rom",
    "options",
}
"""The options of an `AtariEnv` by ale-py's names, and `interventions`."""


def _require_plain(task: Task) -> None:
    """Refuse what an `AtariEnv` does not play alone.

    Raises:
        ValueError: wrappers play the task, or several players.
    """
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
