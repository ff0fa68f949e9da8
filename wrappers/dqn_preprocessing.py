"""`DqnPreprocessing`: from the emulator's frames to the observations of a deep Q-network, in one pass.

It repeats the action, takes the maximum of the last two frames, makes it gray, resizes it and stacks it (Mnih et al.
2015). With separate wrappers, each frame would become an unused RGB observation. `DqnPreprocessing` plays the frames
without observations. The emulator's `ObservationStack`, which also serves `AtariVectorEnv`, reads at most two frames.

Implementations differ in details, mostly in the observation when an episode ends inside a skip; `atari.wrappers.preset`
has the parameters of each.
"""

import copy
import inspect
from typing import Any, Literal, get_args

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker

import atari._emulator as _emulator
from atari.base.validation import check_integer, check_name
from atari.cores import ByteArray
from atari.env import AtariEnv
from atari.env.restorable import RestorableWrapper, State, layers
from atari.env.settings import filled, pixel_format
from atari.games.game import Screen
from atari.task.observation_kinds import KINDS
from atari.wrappers._checks import Environment, require_atari, require_pixels, require_single_frames
from atari.wrappers.episodic_life import EpisodicLife
from atari.wrappers.frame_stack import Padding
from atari.wrappers.images import resize_image

EndFrames = Literal["last", "gymnasium", "baselines", "envpool"]
DqnObsType = Literal["image", "ram"]
ScreenSize = int | tuple[int | None, int | None] | None

# Layers whose `step` need not run for each frame: checks, and `EpisodicLife`, whose rule this wrapper applies.
_TRANSPARENT = (OrderEnforcing, PassiveEnvChecker, EpisodicLife)


class DqnPreprocessing(RestorableWrapper):
    """Frame skip, max-pooling, grayscale, resizing and frame stack.

    Observations are (stack_size, rows, columns) uint8, with `grayscale=False` (stack_size, rows, columns, 3), with
    `stack_size=None` without the first axis; each is a new array. The oldest frame comes first. Rewards are summed.
    With `obs_type="ram"` they are the RAM after each skip, (stack_size, 128) uint8, with `stack_size=None` (128,), and
    no frame is rendered.

    Wrappers that only act at a reset (`NoopReset`, `FireReset`) and `EpisodicLife` can be inside without a cost. If
    any other inner wrapper changes `step`, or each frame is rendered, frames are played through its `step`, which is
    slower and gives the same results. Frames always come from the emulator: changes of observations by inner wrappers
    have no effect.

    Args:
        env: an `AtariEnv` that plays one frame a step, possibly wrapped.
        frame_skip: frames for each action, or (low, high) for a random number within low..high-1 at each step, drawn
            from the environment's generator before the first frame.
        screen_size: side of the square image, or (width, height), like `screen_size` of Gymnasium's
            `AtariPreprocessing`. None in place of a number, or of both, means the size of the screen.
        stack_size: frames, or RAM vectors, in an observation; None means one, without an axis for it.
        grayscale: False keeps red, green and blue.
        max_pool: take the maximum of the last two frames of a skip; False takes the last one.
        pool_rgb: pool red, green and blue, and make them gray as OpenCV afterwards (Baselines, DQN 2015), instead of
            pooling ALE's gray values. It requires `end_frames` "last" or "baselines".
        padding_type: before the first frame of an episode, "reset" repeats it, "zero" is black.
        end_frames: the new frame of the observation when the episode ends inside a skip.
            "last": the last frame of the episode;
            "gymnasium": the previous step's, or its maximum with this skip's last but one; never the episode's last
            (Gymnasium, ale-py's vector environment);
            "baselines": the episode's last frame if it is one of the skip's last two, pooled with the other buffer's
            latest frame (Baselines, Stable-Baselines3, Dopamine);
            "envpool": the episode's last frame if it is one of the skip's last two, else the previous step's.
        seamless_lives: a life lost in an inner `EpisodicLife` does not cut the skip short, and the next reset does not
            clear the stack (EnvPool).
        max_frames: truncate after this many frames, not counting those of inner wrappers; None means never.
        obs_type: "image" or "ram". RAM is not pooled; the arguments about images then have no effect.
            `RamObservation` around this one adds the RAM to images.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range; or the environment is no `AtariEnv`,
            returns RAM in place of pixels, or skips frames already.

    Example:
        >>> import atari
        >>> from atari.wrappers import DqnPreprocessing
        >>> env = DqnPreprocessing(atari.AtariEnv("breakout", frameskip=1))
        >>> env.reset(seed=0)[0].shape
        (4, 84, 84)
        >>> env.step(1)[4]["episode_frame_number"]
        4
    """

    def __init__(
        self,
        env: Environment,
        frame_skip: int | tuple[int, int] = 4,
        screen_size: ScreenSize = 84,
        stack_size: int | None = 4,
        *,
        grayscale: bool = True,
        max_pool: bool = True,
        pool_rgb: bool = False,
        padding_type: Padding = "reset",
        end_frames: EndFrames = "last",
        seamless_lives: bool = False,
        max_frames: int | None = None,
        obs_type: DqnObsType = "image",
    ) -> None:
        arguments = {name: value for name, value in locals().items() if name not in ("self", "env", "__class__")}
        self._atari = require_atari(env, "DqnPreprocessing")
        _check_observations(env, arguments)
        require_single_frames(env, "DqnPreprocessing")
        low, high = _check_frame_skip(frame_skip)
        if stack_size is not None:
            stack_size = check_integer("stack_size", stack_size, 1, 10_000)
        if max_frames is not None:
            max_frames = check_integer("max_frames", max_frames, 1, 2**31)
        check_name("padding_type", padding_type, get_args(Padding))
        check_name("end_frames", end_frames, get_args(EndFrames))
        if pool_rgb and end_frames not in ("last", "baselines"):
            raise ValueError(f"pool_rgb goes with end_frames='last' or 'baselines', got {end_frames!r}")
        frame_skip = low if high == low + 1 else (low, high)
        given = {"frame_skip": frame_skip, "stack_size": stack_size, "max_frames": max_frames}
        recorded: dict[str, Any] = {
            name: list(value) if isinstance(value, tuple) else value  # the form of JSON
            for name, value in {**arguments, **given}.items()
        }
        super().__init__(env, **recorded)
        self.frame_skip = frame_skip
        self._max_frames = max_frames
        self._direct = _can_drive_directly(env, self._atari)
        self._life = next((layer for layer in layers(env) if isinstance(layer, EpisodicLife)), None)
        self._seamless_life = self._life if seamless_lives else None
        self._frames_played = 0
        self._frame_number = 0
        self._info: dict[str, Any] = {}
        self._stacked = stack_size is not None
        self._resized: tuple[int, int] | None = None
        self._images: _emulator.ObservationStack | None = None
        screen = self._atari.game.screen
        kind = KINDS[("grayscale" if grayscale else "rgb") if obs_type == "image" else obs_type]
        settings = {
            "pixels": pixel_format(kind, pool_rgb=pool_rgb),
            "stack_num": stack_size or 1,
            "maxpool": max_pool,
            "end_frames": _emulator.EndFrames[end_frames.upper()],
            "padding": _emulator.Padding[padding_type.upper()],
        }
        self._pools = max_pool and kind.image is not None
        size = screen.shape
        shown: tuple[int, ...] = (128,)
        if kind.image:
            width, height = _check_size(screen_size, screen.shape)
            shown = (height, width, *kind.colours)
            if height > screen.shape[0] or width > screen.shape[1]:
                self._resized = height, width  # from images of the screen
            else:
                size = height, width
        if kind.image or self._stacked:
            self._images = _make_images(screen, *size, settings)
        self.observation_space = spaces.Box(0, 255, (stack_size or 1, *shown)[not self._stacked :], np.uint8)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset; the observation is the screen after the resets of the inner wrappers.

        Args:
            seed: the seed of the environment.
            options: for the inner wrappers: "noops" (`NoopReset`), "fire" (`FireReset`), "new_game" (`EpisodicLife`).
        """
        if self._max_frames is not None and self._frames_played >= self._max_frames:
            options = {**(options or {}), "new_game": True}  # an inner EpisodicLife has no access to this limit
        _, info = self.env.reset(seed=seed, options=options)
        same_game = self._life is not None and self._life.same_game
        if not same_game:
            self._frames_played = 0
        return self._first_observation(same_game), {**info, **self._atari.driver.info()}

    @property
    def keeps_stack(self) -> bool:
        """Whether the last reset continued the same game with the same stack."""
        return self._seamless_life is not None and self._seamless_life.same_game

    def _first_observation(self, same_game: bool) -> ByteArray:
        """The observation after a reset that has continued the same game or begun a new one."""
        core, images = self._atari.core, self._images
        if images is not None:
            fill = not same_game or self._seamless_life is None
            if same_game and core.frame_number == self._frame_number:
                images.repeat(fill)
            else:
                images.begin(self._atari.driver.observed, fill)
        return self._observation()

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play the action until the skip or the episode ends."""
        driver, images, seamless, most = self._atari.driver, self._images, self._seamless_life, self._max_frames
        self._warn_if_restored()
        play = self._play_direct if self._direct else self._play_through
        move = driver.ale_action(action) if self._direct else action
        left = self.frame_skip if isinstance(self.frame_skip, int) else driver.draw(*self.frame_skip)
        total = 0.0
        ended = False
        while left and not ended:
            frames = left - 1 or 1  # up to the last but one, because `images` reads it
            if most is not None:
                frames = min(frames, max(most - self._frames_played, 1))
            reward, played, terminated, truncated = play(move, frames)
            total += reward
            left -= played
            if seamless is not None and seamless.life_lost:
                terminated = False  # reported after the skip has been played
            if most is not None:
                self._frames_played += played
                truncated = truncated or (self._frames_played >= most and not terminated)
            ended = terminated or truncated
            if left == 1 and images is not None and self._pools:
                # Inner wrappers may do anything to the emulator before its next frame.
                images.frame_played(driver.observed if self._direct else driver.observed.screen(), left, ended)
        if images is not None:
            images.skip_ended(driver.observed, left, ended)
        if seamless is not None and seamless.life_lost:
            terminated = not truncated
        info = driver.info() if self._direct else self._info
        self._frame_number = info["frame_number"]
        return self._observation(), total, terminated, truncated, info

    def _play_direct(self, move: tuple[int, float], frames: int) -> tuple[float, int, bool, bool]:
        """Play up to `frames` frames on the emulator: until the game ends, or the number of lives changes."""
        driver = self._atari.driver
        reward, played = driver.play_until(*move, frames=frames)
        core = driver.core
        ended = driver.phase != "playing"
        terminated, truncated = ended and core.game_over, ended and core.truncated
        if self._life is not None:
            terminated = self._life.observe(core.lives, terminated, truncated)
        return reward, played, terminated, truncated

    def _play_through(self, action: Any, frames: int) -> tuple[float, int, bool, bool]:
        _, reward, terminated, truncated, self._info = self.env.step(action)
        return float(reward), 1, terminated, truncated

    def _observation(self) -> ByteArray:
        if self._images is None:
            return self._atari.driver.observed.ram()
        stack = self._images.observation()
        if self._resized is not None:
            stack = np.stack([resize_image(image, self._resized) for image in stack])
        return stack if self._stacked else stack[0]

    def _save_state(self) -> State:
        state: dict[str, Any] = {"_frames_played": self._frames_played, "_frame_number": self._frame_number}
        if self._images is not None:
            state["images"] = np.frombuffer(self._images.save(), np.uint8)
        return state

    def _load_state(self, state: State) -> dict[str, Any]:
        attributes = dict(state)
        if self._images is not None:
            attributes["_images"] = copy.copy(self._images)
            attributes["_images"].load(attributes.pop("images").tobytes())
        return attributes


_ALSO_OF_RAM = ("frame_skip", "stack_size", "padding_type", "seamless_lives", "max_frames", "obs_type")


def _check_observations(env: Environment, arguments: dict[str, Any]) -> None:
    if check_name("obs_type", arguments["obs_type"], get_args(DqnObsType)) == "image":
        require_pixels(env, "DqnPreprocessing")
        return
    if not isinstance(env.observation_space, spaces.Box):
        raise ValueError("DqnPreprocessing(obs_type='ram') has no sound; make the environment with sound_obs=False")
    parameters = inspect.signature(DqnPreprocessing).parameters
    for name, value in arguments.items():
        if name not in _ALSO_OF_RAM and value != parameters[name].default:
            raise ValueError(f"{name}={value!r} is about images and has no effect with obs_type='ram'; leave it out")


def _check_frame_skip(frame_skip: Any) -> tuple[int, int]:
    """`frame_skip` as (low, high), which means low..high-1 frames."""
    if not isinstance(frame_skip, (tuple, list)):
        frames = check_integer("frame_skip", frame_skip, 1, 10_000)
        return frames, frames + 1
    if len(frame_skip) != 2:
        raise ValueError(f"frame_skip must be an integer or (low, high), got {frame_skip!r}")
    low, high = (check_integer("frame_skip", frames, 1, 10_001) for frames in frame_skip)
    if low >= high:
        raise ValueError(f"frame_skip (low, high) is low..high-1 frames and needs low < high, got {frame_skip!r}")
    return low, high


def _check_size(screen_size: Any, screen: tuple[int, int]) -> tuple[int, int]:
    """`screen_size` as (width, height); None means the size (rows, columns) of the screen."""
    pair = screen_size if isinstance(screen_size, (tuple, list)) else (screen_size, screen_size)
    if len(pair) != 2:
        raise ValueError(f"screen_size must be an integer or (width, height), got {screen_size!r}")
    given = (own if length is None else length for length, own in zip(pair, reversed(screen), strict=True))
    width, height = (check_integer("screen_size", length, 1, 10_000) for length in given)
    return width, height


def _make_images(screen: Screen, height: int, width: int, settings: dict[str, Any]) -> _emulator.ObservationStack:
    made = filled(_emulator.ObservationSettings(), img_height=height, img_width=width, **settings)
    return _emulator.ObservationStack(made, screen.shape[0], screen.format)


def _can_drive_directly(env: Environment, atari: AtariEnv) -> bool:
    """Whether the `step` of each inner layer only plays a frame."""
    plain = all(
        type(layer).step is gymnasium.Wrapper.step or type(layer) in _TRANSPARENT
        for layer in layers(env)
        if layer is not atari
    )
    return plain and not atari.has_own_step and atari.render_mode in (None, "rgb_array")
