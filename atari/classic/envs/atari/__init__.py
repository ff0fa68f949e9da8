"""Atari games: `AtariEnv`, with the constructor and the attributes of Gym's class."""

import operator
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

import atari
from atari.classic.envs.adapted import Adapted

__all__ = ["AtariEnv"]

FrameSkip = int | tuple[int, int]

ACTION_MEANING = {int(action): action.name for action in atari.Action}
"""The name of each action of the joystick."""

_RENAMED = {"getScreenRGB2": "getScreenRGB"}
_KEYS = {"UP": "w", "DOWN": "s", "LEFT": "a", "RIGHT": "d", "FIRE": " "}


class AtariEnv(Adapted):
    """A game.

    Args:
        game: its name, such as "pong".
        mode: the game's mode; None means the usual one.
        difficulty: the game's difficulty; None means the usual one.
        obs_type: "ram", observations (128,) uint8; "image", (rows, 160, 3) uint8.
        frameskip: frames a step, or the range (low, high - 1) in which each step draws it.
        repeat_action_probability: the probability that a frame repeats the action before.
        full_action_space: all 18 actions, not only those that the game uses.

    Raises:
        TypeError, ValueError: an argument is of the wrong kind, or not offered by the game.
        FileNotFoundError: no ROM file of the game was found.

    Example:
        >>> from atari import classic
        >>> env = classic.envs.atari.AtariEnv("pong", obs_type="image", frameskip=4)
        >>> env.reset().shape
        (210, 160, 3)
        >>> isinstance(classic.make("Pong-v0").unwrapped, classic.envs.atari.AtariEnv)
        True
    """

    original = atari.AtariEnv
    _frameskip: FrameSkip | None = None
    """The frames of a step, if a script assigned them."""

    def __init__(
        self,
        game: str = "pong",
        mode: int | None = None,
        difficulty: int | None = None,
        obs_type: Literal["ram", "image"] = "ram",
        frameskip: FrameSkip = (2, 5),
        repeat_action_probability: float = 0.0,
        full_action_space: bool = False,
    ) -> None:
        options = {
            "game": game,
            "mode": mode,
            "difficulty": difficulty,
            "obs_type": obs_type,
            "frameskip": frameskip,
            "repeat_action_probability": repeat_action_probability,
            "full_action_space": full_action_space,
        }
        super().__init__(**modern_options(options), max_num_frames_per_episode=None)

    @property
    def _env(self) -> atari.AtariEnv:
        return self.modern.unwrapped  # type: ignore[return-value]

    @property
    def ale(self) -> Any:
        """The emulator by the method names of ale-py and atari-py; a script may assign an object around it."""
        return OldAle(self._env.ale)

    @ale.setter
    def ale(self, ale: Any) -> None:
        self._env.ale = ale.interface if isinstance(ale, OldAle) else ale

    @property
    def game(self) -> str:
        """The game's name."""
        return self._env.game.id

    @property
    def game_path(self) -> str:
        """The ROM file.

        Raises:
            FileNotFoundError: no ROM file of the game was found.
        """
        return str(atari.roms.find(self.game))

    @property
    def game_mode(self) -> int | None:
        """The mode of the game."""
        return self._env.task.mode

    @property
    def game_difficulty(self) -> int | None:
        """The difficulty of the game."""
        return self._env.task.difficulty

    @property
    def frameskip(self) -> FrameSkip:
        """Frames a step, or the range in which each step draws it; a script may assign it.

        Raises:
            TypeError, ValueError: the assigned value is no frame skip.
        """
        return self._env.task.frameskip if self._frameskip is None else self._frameskip

    @frameskip.setter
    def frameskip(self, frames: FrameSkip) -> None:
        self._frameskip = self._env.task.replace(frameskip=frames).frameskip

    def get_keys_to_action(self) -> dict[tuple[int, ...], int]:
        """The action of each combination of keys, which are the sorted numbers of their characters."""
        return {
            tuple(sorted(ord(key) for part, key in _KEYS.items() if part in meaning)): action
            for action, meaning in enumerate(self.get_action_meanings())
        }

    def get_action_meanings(self) -> list[str]:
        """The name of each action of the action space."""
        return self._env.get_action_meanings()

    def clone_full_state(self) -> Any:
        """The state of the emulator, with its random generator."""
        return self._env.clone_state(include_rng=True)

    def restore_full_state(self, state: Any) -> None:
        """Continue from a state of `clone_full_state`."""
        self._env.restore_state(state)

    def reset(self, **options: Any) -> Any:
        """Start a new game, and return its first observation."""
        return self._seen(super().reset(**options))

    def _get_obs(self) -> Any:
        """The observation. A subclass may replace it, `_get_image` or `_get_ram`."""
        kind = self._env.task.kind
        if not kind.image:
            return self._get_ram()
        return self._get_image() if kind.colours else self._env.observe()

    def _get_image(self) -> npt.NDArray[np.uint8]:
        return self._env.core.screen_rgb()

    def _get_ram(self) -> npt.NDArray[np.uint8]:
        return self._env.core.ram()

    def _seen(self, observation: Any) -> Any:
        """The observation, or what the hooks of a subclass make of it."""
        kind = type(self)
        hooks = (kind._get_obs, kind._get_image, kind._get_ram)
        is_plain = hooks == (AtariEnv._get_obs, AtariEnv._get_image, AtariEnv._get_ram)
        return observation if is_plain else self._get_obs()

    def _render_as(self, mode: str) -> Any:
        is_plain = mode != "rgb_array" or type(self)._get_image is AtariEnv._get_image
        return super()._render_as(mode) if is_plain else self._get_image()

    def _play(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        observation, *others = self._play_frames(action)
        return self._seen(observation), *others

    def _play_frames(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        frames = self._frameskip
        if frames is None:
            return super()._play(action)
        if not isinstance(frames, int):
            frames = operator.index(self.np_random.randint(*frames))
        env = self._env
        number, strength = env.driver.ale_action(action)
        reward = env.driver.play_frames(number, strength, frames=frames)
        return env.observe(), reward, env.core.game_over, env.core.truncated, env.driver.info()


def modern_options(options: dict[str, Any]) -> dict[str, Any]:
    """Options of Gym's Atari environments as options of `atari.AtariEnv`."""
    return {**options, "obs_type": "rgb"} if options.get("obs_type") == "image" else options


def old_options(options: dict[str, Any]) -> dict[str, Any]:
    """The options of a registered game as Gym's registry had them, which `AtariEnv` takes."""
    names = ("game", "frameskip", "repeat_action_probability", "full_action_space")
    return {"obs_type": options.get("obs_type", "image"), **{name: options[name] for name in names if name in options}}


def to_ram(ale: Any) -> npt.NDArray[np.uint8]:
    """The RAM of an emulator, (128,) uint8."""
    return np.array(ale.getRAM(), np.uint8)


class OldAle:
    """`env.unwrapped.ale` by the names of atari-py: methods of ale-py's interface, which also take texts as bytes.

    Args:
        interface: ale-py's interface, or an object of a script around it.
    """

    def __init__(self, interface: Any) -> None:
        self.interface = interface

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name == "interface":  # `copy` looks them up before they exist
            raise AttributeError(name)
        value = getattr(self.interface, _RENAMED.get(name, name))
        return _with_texts(value) if callable(value) else value


def _with_texts(method: Callable[..., Any]) -> Callable[..., Any]:
    """The method, with `bytes` among its arguments decoded."""

    def call(*arguments: Any, **options: Any) -> Any:
        return method(*(each.decode() if isinstance(each, bytes) else each for each in arguments), **options)

    return call
