"""`DqnPreprocessing`: from the emulator's frames to the observations of a deep Q-network, in one pass.

Repeat the action, take the maximum of the last two frames, make it gray, scale it down, stack it (Mnih et al. 2015).
With separate wrappers, each frame would become an unused RGB observation. `DqnPreprocessing` plays the frames without
observations, reads at most two of them from the emulator, and writes the result into the returned array.

Implementations differ in details, mostly in the observation when an episode ends inside a skip; `atari.wrappers.preset`
has the parameters of each.
"""

import contextlib
import inspect
from collections.abc import Callable
from functools import partial
from typing import Any, Literal, get_args

import cv2
import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker

from atari import _emulator
from atari.cores import ByteArray
from atari.env import AtariEnv
from atari.restorable import Restorable, layers, warn_of_restore
from atari.validation import check_integer, check_name
from atari.wrappers._checks import Environment, require_atari, require_pixels, require_single_frames
from atari.wrappers._rgb_pool import RgbPool
from atari.wrappers.episodic_life import EpisodicLife
from atari.wrappers.frame_stack import Padding

EndFrames = Literal["last", "gymnasium", "baselines", "envpool"]
DqnObsType = Literal["image", "ram"]
ScreenSize = int | tuple[int | None, int | None] | None

# Layers whose `step` need not be called for each frame: checks, and `EpisodicLife`, whose rule this wrapper applies.
_TRANSPARENT = (OrderEnforcing, PassiveEnvChecker, EpisodicLife)


class DqnPreprocessing(Restorable, gymnasium.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """Frame skip, max-pooling, grayscale, resizing and frame stack.

    Observations are (stack_size, rows, columns) uint8, with `grayscale=False` (stack_size, rows, columns, 3), with
    `stack_size=None` without the first axis; each is a new array. The oldest frame comes first. Rewards are summed.
    With `obs_type="ram"` they are the RAM after the skip, (128,) uint8, and no frame is rendered.

    Wrappers that only act at a reset (`NoopReset`, `FireReset`) and `EpisodicLife` can be inside without a cost. If
    any other inner wrapper changes `step`, or each frame is rendered, frames are played through its `step`, which is
    slower and gives the same. Frames are always read from the emulator: changes of observations by inner wrappers
    have no effect.

    Args:
        env: an `AtariEnv` that plays one frame a step, possibly wrapped.
        frame_skip: frames for each action, or (low, high) for a random number within low..high-1 at each step, drawn
            from the environment's generator before the first frame.
        screen_size: side of the square image, or (width, height), as Gymnasium's `AtariPreprocessing` has it; None in
            place of a number or of all is the size of the screen.
        stack_size: frames in an observation; None is one frame without an axis for it.
        grayscale: False keeps red, green and blue.
        max_pool: take the maximum of the last two frames of a skip; False takes the last one.
        pool_rgb: pool red, green and blue, and make them gray with OpenCV afterwards (Baselines, DQN 2015), instead of
            pooling ALE's gray values. Goes with `end_frames` "last" and "baselines".
        padding_type: before the first frame of an episode, "reset" repeats it, "zero" is black.
        end_frames: the new frame of the observation when the episode ends inside a skip.
            "last": the last frame of the episode;
            "gymnasium": not that frame; the previous step's, or its maximum with this skip's last but one
            (Gymnasium, ale-py's vector environment);
            "baselines": that frame if it is one of the skip's last two, pooled with the other buffer's latest frame
            (Baselines, Stable-Baselines3, Dopamine);
            "envpool": that frame if it is one of the skip's last two, else the previous step's.
        seamless_lives: a life lost in an inner `EpisodicLife` neither cuts the skip short nor clears the stack at the
            reset that follows (EnvPool).
        max_frames: truncate after this many frames, not counting those of inner wrappers; None is never.
        obs_type: "image" or "ram". RAM is neither stacked nor pooled; the arguments about images stay as they are then.
            `RamObservation` around this one adds the RAM to images.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind or out of range; the environment is no `AtariEnv`, gives
            RAM in place of the pixels that are to be preprocessed, or skips frames already.

    Example:
        >>> import atari
        >>> from atari.wrappers import DqnPreprocessing
        >>> env = DqnPreprocessing(atari.AtariEnv("breakout", frameskip=1))
        >>> env.reset(seed=0)[0].shape
        (4, 84, 84)
        >>> env.step(1)[4]["episode_frame_number"]
        4
    """

    _state = ("_early", "_late", "_stack", "_frames_played", "_frame_number")

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
        self._size = _check_size(screen_size, self._atari.game.screen.shape)
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
            name: list(value) if isinstance(value, tuple) else value  # as JSON has them
            for name, value in {**arguments, **given}.items()
        }
        RecordConstructorArgs.__init__(self, **recorded)
        super().__init__(env)
        self.frame_skip = frame_skip
        self._max_frames = max_frames
        self._reads_ram = obs_type == "ram"
        self._frames_read = 0 if self._reads_ram else 2 if max_pool and high > 2 else 1
        self._pads_zero = padding_type == "zero"
        self._end_frames = end_frames
        self._direct = _can_drive_directly(env, self._atari)
        self._life = next((layer for layer in layers(env) if isinstance(layer, EpisodicLife)), None)
        self._seamless_life = self._life if seamless_lives else None
        self._frames_played = 0
        self._frame_number = 0
        self._info: dict[str, Any] = {}
        self._grayscale = grayscale
        self._rgb_pool = RgbPool(self._atari.game.screen.format) if pool_rgb and grayscale else None
        self._make_buffers(stack_size)

    def _make_buffers(self, stack_size: int | None) -> None:
        """Arrays for the frames from the emulator (gray values, palette indices or colours) and for the stack."""
        colours = () if self._grayscale else (3,)
        raw: tuple[int, ...] = (*self._atari.game.screen.shape, *colours)
        image: tuple[int, ...] = (self._size[1], self._size[0], *colours)
        if self._reads_ram:
            raw = image = (0,)
        self._early: ByteArray = np.zeros(raw, np.uint8)  # the last frame but one of a skip
        self._late: ByteArray = np.zeros(raw, np.uint8)  # the last one
        self._pooled: ByteArray = np.zeros(raw, np.uint8)
        self._stacked = stack_size is not None
        self._stack: ByteArray = np.zeros((stack_size or 1, *image), np.uint8)
        self._shrink = _shrinker(self._atari.game.screen.shape[0], self._size, self._grayscale)
        shown = (128,) if self._reads_ram else self._stack.shape if self._stacked else image
        self.observation_space = spaces.Box(0, 255, shown, np.uint8)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset; the observation is the screen after the resets of the inner wrappers.

        Args:
            seed: of the environment.
            options: for the inner wrappers: "noops" (`NoopReset`), "fire" (`FireReset`), "new_game" (`EpisodicLife`).
        """
        if self._max_frames is not None and self._frames_played >= self._max_frames:
            options = {**(options or {}), "new_game": True}  # an inner EpisodicLife has no access to this limit
        _, info = self.env.reset(seed=seed, options=options)
        same_game = self._life is not None and self._life.same_game
        if not same_game:
            self._frames_played = 0
        return self._first_observation(same_game), {**info, **self._atari._info()}

    def _first_observation(self, same_game: bool) -> ByteArray:
        """The observation after a reset, which has continued the same game or begun a new one."""
        if self._reads_ram:
            return self._atari.core.ram()
        fill = not same_game or self._seamless_life is None
        if same_game and self._atari.core.frame_number == self._frame_number:
            return self._push(None, fill)
        # The array of the image that is shown again if the first skip is cut short.
        kept_late = self._end_frames == "gymnasium" or self._frames_read == 1
        shown, other = (self._late, self._early) if kept_late else (self._early, self._late)
        self._read(shown)
        other.fill(0)
        return self._push(self._single(shown), fill)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Play the action until the skip or the episode ends."""
        if self._atari._restored:
            warn_of_restore(self.env, "DqnPreprocessing")
        play = self._play_direct if self._direct else self._play_through
        move = self._atari._ale_action(action) if self._direct else action
        seamless = self._seamless_life
        skip = self.frame_skip if isinstance(self.frame_skip, int) else self._atari._draw(*self.frame_skip)
        total = 0.0
        left = skip
        ended = False
        while left and not ended:
            reward, terminated, truncated = play(move)
            total += reward
            left -= 1
            if seamless is not None and seamless.life_lost:
                terminated = False  # reported after the skip has been played
            if self._max_frames is not None:
                self._frames_played += 1
                truncated = truncated or (self._frames_played >= self._max_frames and not terminated)
            ended = terminated or truncated
            if left < self._frames_read and not (ended and self._end_frames == "gymnasium"):
                self._read(self._early if left else self._late)
        if seamless is not None and seamless.life_lost:
            terminated = not truncated
        if skip == 1 < self._frames_read:
            np.copyto(self._early, self._late)  # a skip of one frame has no other to pool
        observation = self._atari.core.ram() if self._reads_ram else self._push(self._final_frame(whole=left == 0))
        info = self._atari._info() if self._direct else self._info
        self._frame_number = info["frame_number"]
        return observation, total, terminated, truncated, info

    def _play_direct(self, move: tuple[int, float]) -> tuple[float, bool, bool]:
        """Play a frame on the emulator."""
        atari = self._atari
        reward = atari.play_frames(move[0], 1, move[1])
        core = atari.core
        ended = atari._phase != "playing"
        terminated, truncated = ended and core.game_over, ended and core.truncated
        if self._life is not None:
            terminated = self._life.observe(core.lives, terminated, truncated)
        return reward, terminated, truncated

    def _play_through(self, action: Any) -> tuple[float, bool, bool]:
        """Play a frame through the inner wrappers."""
        _, reward, terminated, truncated, self._info = self.env.step(action)
        return float(reward), terminated, truncated

    def _read(self, out: ByteArray) -> None:
        """Fill `out` with the screen."""
        core = self._atari.core
        if self._rgb_pool is not None:
            core.screen(out)
        elif self._grayscale:
            core.screen_grayscale(out)
        else:
            core.screen_rgb(out)

    def _final_frame(self, whole: bool) -> ByteArray:
        """The frame for the observation after a skip; `whole` is whether the skip was played to its end."""
        early, late, pooled = self._early, self._late, self._pooled
        if self._end_frames == "last" and not whole:
            self._read(late)
            return self._single(late)
        if self._frames_read == 1:
            return self._single(late)
        if self._end_frames == "gymnasium":
            return np.maximum(late, early, out=late)  # in place: a later stale frame is this maximum
        if self._end_frames == "envpool":
            return np.maximum(early, late, out=early) if whole else early
        if self._rgb_pool is not None:
            return self._rgb_pool.pooled(early, late, pooled)
        return np.maximum(early, late, out=pooled)

    def _single(self, frame: ByteArray) -> ByteArray:
        """The image of one frame."""
        return frame if self._rgb_pool is None else self._rgb_pool.gray(frame, self._pooled)

    def _push(self, image: ByteArray | None, fill: bool = False) -> ByteArray:
        """Resize an image and append it to the stack, or, with `fill`, start a stack with it.

        None appends the last image again.
        """
        stack = np.empty_like(self._stack)
        if image is None:
            stack[-1] = self._stack[-1]
        else:
            self._shrink(image, stack[-1])
        if not fill:
            stack[:-1] = self._stack[1:]
        else:
            stack[:-1] = 0 if self._pads_zero else stack[-1]
        self._stack = stack
        observation: ByteArray = stack.copy() if self._stacked else stack[0]
        return observation


_ALSO_OF_RAM = ("frame_skip", "seamless_lives", "max_frames", "obs_type")


def _check_observations(env: Environment, arguments: dict[str, Any]) -> None:
    """Check that the environment and the arguments fit what is observed."""
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
    """`frame_skip` as (low, high), for low..high-1 frames."""
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
    """`screen_size` as (width, height), with the size (rows, columns) of the screen for None."""
    pair = screen_size if isinstance(screen_size, (tuple, list)) else (screen_size, screen_size)
    if len(pair) != 2:
        raise ValueError(f"screen_size must be an integer or (width, height), got {screen_size!r}")
    given = (own if length is None else length for length, own in zip(pair, reversed(screen), strict=True))
    width, height = (check_integer("screen_size", length, 1, 10_000) for length in given)
    return width, height


def _shrinker(rows: int, size: tuple[int, int], grayscale: bool) -> Callable[[ByteArray, ByteArray], object]:
    """The resize function: our own if it supports the shape (faster, same bytes), else OpenCV's."""
    if grayscale:
        with contextlib.suppress(ValueError):
            return _emulator.AreaResize(rows, size[1], size[0])
    return partial(_shrink, size)


def _shrink(size: tuple[int, int], image: ByteArray, out: ByteArray) -> None:
    cv2.resize(image, size, dst=out, interpolation=cv2.INTER_AREA)


def _can_drive_directly(env: Environment, atari: AtariEnv) -> bool:
    """Whether the `step` of all inner layers does no more than to play a frame."""
    plain = all(
        type(layer).step is gymnasium.Wrapper.step or type(layer) in _TRANSPARENT
        for layer in layers(env)
        if layer is not atari
    )
    return plain and type(atari).step is AtariEnv.step and atari.render_mode in (None, "rgb_array")
