"""`env.unwrapped.ale`: a running game under the method names of ale-py's `ALEInterface`.

Wrappers of Gymnasium and Stable-Baselines3 call `env.unwrapped.ale.lives()` and other methods of ale-py. `AleInterface`
has these methods for every core, with the core's checks. docs/ale-py.md lists the differences.
"""

import enum
from collections.abc import Mapping
from os import PathLike, fsdecode, fspath
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from atari.base import durable
from atari.base.frozen import FrozenDict
from atari.base.png import png
from atari.base.validation import AleError, AleTypeError, check_integer, check_poke, check_probability
from atari.cores.ale_actions import Action as AleAction
from atari.cores.core import ByteArray, Core
from atari.cores.options import SEED_LIMIT
from atari.games.game import Game
from atari.roms.identification import by_content
from atari.roms.image import read_image


class AleBufferError(TypeError, ValueError, RuntimeError):
    """A buffer that cannot be filled: ale-py raises `TypeError`, or `RuntimeError` for some wrong shapes."""


_DEFAULTS: dict[str, Any] = {
    "random_seed": -1,
    "frame_skip": 1,
    "max_num_frames_per_episode": 0,
    "repeat_action_probability": 0.25,
    "color_averaging": False,
    "sound_obs": False,
    "sound": False,
    "display_screen": False,
    "record_screen_dir": "",
    "record_sound_filename": "",
}

_UNUSED = {"sound": "render_mode='human'", "display_screen": "render_mode='human'"} | dict.fromkeys(
    ("record_screen_dir", "record_sound_filename"), "atari.recording"
)
"""Settings of ale-py that no core has, with their replacements. They can be set to their default."""


class AleSettings:
    """Settings by ale-py's names. As in ale-py, a setting applies when the game is next loaded.

    `stale` says whether a setting changed after the last load.
    """

    choices: Mapping[str, int | None] = FrozenDict()
    """The "mode" and the "difficulty" of the next load in place of the first ones; None is the game's default."""

    def __init__(self, **values: Any) -> None:
        self._values: dict[str, Any] = {**_DEFAULTS, **values}
        self.stale = False

    def get(self, name: str | bytes, kind: type) -> Any:
        """The value of a setting of this kind.

        Raises:
            AleError: there is no such setting of this kind.
        """
        name = fsdecode(name)
        names = [key for key, default in _DEFAULTS.items() if type(default) is kind]
        if name not in names:
            raise AleError(f"there is no {kind.__name__} setting {name!r}; there are {', '.join(names)}")
        return kind(self._values[name])

    def set(self, name: str | bytes, kind: type, value: Any) -> None:
        """Set a setting for the next load.

        Raises:
            TypeError: the value is of another kind.
            ValueError: it is out of range. AleError: see `get`, or another option does the setting's work.
        """
        before = self.get(name, kind)
        name = fsdecode(name)
        checked = _checked(name, kind, value)
        if name in _UNUSED and checked != before:
            raise AleError(f"{name} is not supported; use {_UNUSED[name]} instead")
        self._values[name] = checked
        self.stale = self.stale or name not in (*_UNUSED, "random_seed")

    def choose(self, name: str, number: int | None) -> None:
        """Set the "mode" or the "difficulty" of the next load."""
        self.choices = {**self.choices, name: number}
        self.stale = True

    def seed(self) -> int:
        """The seed of the next load, 0 .. 2**32 - 1; a new random one if `random_seed` is -1."""
        seed: int = self._values["random_seed"]
        return int(np.random.SeedSequence().generate_state(1)[0]) if seed == -1 else seed % SEED_LIMIT

    def set_seed(self, seed: int) -> None:
        """Set the seed of the next load, 0 .. 2**32 - 1. As for every core, 2**32 - 1 becomes 2**32 - 2."""
        self._values["random_seed"] = (min(seed, SEED_LIMIT - 2) + 2**31) % SEED_LIMIT - 2**31

    def core_options(self) -> dict[str, Any]:
        """The options of a core, without seed, mode and difficulty."""
        names = ("repeat_action_probability", "frame_skip", "max_num_frames_per_episode", "color_averaging")
        return {**{name: self._values[name] for name in names}, "sound": self._values["sound_obs"]}


def _checked(name: str, kind: type, value: Any) -> Any:
    if kind is bool or kind is str:
        if not isinstance(value, kind) and not (kind is bool and isinstance(value, np.bool_)):
            raise TypeError(f"{name} must be a {kind.__name__}, got {value!r}")
        return kind(value)
    if kind is float:
        return check_probability(name, value)
    low, high = {"random_seed": (-(2**31), 2**31 - 1), "frame_skip": (1, 10_000)}.get(name, (0, 2**31 - 1))
    return check_integer(name, value, low, high)


class AleConsole(Protocol):
    """The console that an `AleInterface` plays: the driver of an environment, or a console without one."""

    ale_settings: AleSettings

    @property
    def emulated(self) -> Core:
        """The emulator core."""

    def game_was_reset(self) -> None:
        """Note that the emulator was reset. A console counts nothing."""
        return

    def load_game(self) -> None:
        """Load the game again, with the settings."""

    def restore_state(self, state: Any) -> None:
        """Continue from a state that `clone_state` returned."""
        self.emulated.restore_state(state)


class AleInterface:
    """The methods of ale-py's `ALEInterface` for a running game; ale-py documents each.

    Arrays and errors are as in `atari.cores.Core`, with `AleError` where ale-py raises RuntimeError.
    """

    # ruff: noqa: D102 - the names are ale-py's, one line each

    __slots__ = ("_console",)  # as in ale-py, a method cannot be replaced by setting an attribute

    def __init__(self, console: AleConsole) -> None:
        self._console = console

    @property
    def _core(self) -> Core:
        return self._console.emulated

    def act(self, action: int | enum.Enum, paddle_strength: float = 1.0) -> int:
        return self._core.act(action.value if isinstance(action, enum.Enum) else action, paddle_strength)

    def reset_game(self) -> None:
        self._core.reset()
        self._console.game_was_reset()

    def loadROM(self, rom: str | PathLike[str]) -> None:
        """Load the game again, with the settings.

        Raises:
            AleError: there is no such file, or it is no ROM of the environment's game.
        """
        game = self._core.game
        if self.isSupportedROM(rom) != game.id:
            raise AleError(f"{fspath(rom)} is not a ROM file of {game.id}; make an environment of its game")
        self._console.load_game()

    def lives(self) -> int:
        return self._core.lives

    def game_over(self, with_truncation: bool = True) -> bool:
        return self._core.game_over or (with_truncation and self._core.truncated)

    def game_truncated(self) -> bool:
        return self._core.truncated

    def getFrameNumber(self) -> int:
        return self._core.frame_number

    def getEpisodeFrameNumber(self) -> int:
        return self._core.episode_frame_number

    def getRAM(self, buffer: ByteArray | None = None) -> ByteArray:
        return _filled("getRAM", self._core.ram, buffer)

    def getRAMSize(self) -> int:
        return 128

    def setRAM(self, index: int, value: int) -> None:
        try:
            check_poke(0, value)
        except ValueError as error:
            raise AleTypeError(str(error)) from None
        try:
            self._core.set_ram(index, value)
        except ValueError as error:
            raise AleError(str(error)) from None

    def getScreen(self, buffer: ByteArray | None = None) -> ByteArray:
        return _filled("getScreen", self._core.screen, buffer)

    def getScreenRGB(self, buffer: ByteArray | None = None) -> ByteArray:
        return _filled("getScreenRGB", self._core.screen_rgb, buffer)

    def getScreenGrayscale(self, buffer: ByteArray | None = None) -> ByteArray:
        return _filled("getScreenGrayscale", self._core.screen_grayscale, buffer)

    def getScreenDims(self) -> tuple[int, int]:
        return self._core.game.screen.shape

    def saveScreenPNG(self, path: str | PathLike[str]) -> None:
        """Write the screen, each pixel twice as wide as high, as a PNG file.

        Raises:
            OSError: the file cannot be written.
        """
        durable.write_file(Path(path), png(self._core.screen_rgb().repeat(2, axis=1)))

    def getAudio(self, buffer: ByteArray | None = None) -> ByteArray:
        return _filled("getAudio", self._core.audio, buffer)

    def getAudioSize(self) -> int:
        return 512

    def getMinimalActionSet(self) -> list[AleAction]:
        return [AleAction(action) for action in self._core.game.minimal_actions]

    def getLegalActionSet(self) -> list[AleAction]:
        return [AleAction(action) for action in self._core.game.legal_actions]

    def getAvailableModes(self) -> list[int]:
        return list(self._core.game.modes)

    def setMode(self, mode: int) -> None:
        """Play this mode from the next reset on, until the game is loaded again."""
        _choose(self._core.set_mode, mode)
        self._console.ale_settings.stale = True

    def getAvailableDifficulties(self) -> list[int]:
        return list(self._core.game.difficulties)

    def setDifficulty(self, difficulty: int) -> None:
        """Play this difficulty from the next frame on, until the game is loaded again."""
        _choose(self._core.set_difficulty, difficulty)
        self._console.ale_settings.stale = True

    def cloneState(self, include_rng: bool = False) -> Any:
        return self._core.clone_state(include_rng=include_rng)

    def restoreState(self, state: Any) -> None:
        self._console.restore_state(state)

    def cloneSystemState(self) -> Any:
        return self._core.clone_state(include_rng=True)

    def restoreSystemState(self, state: Any) -> None:
        self._console.restore_state(state)

    def getInt(self, key: str | bytes) -> int:
        return int(self._console.ale_settings.get(key, int))

    def setInt(self, key: str | bytes, value: int) -> None:
        self._console.ale_settings.set(key, int, value)

    def getFloat(self, key: str | bytes) -> float:
        return float(self._console.ale_settings.get(key, float))

    def setFloat(self, key: str | bytes, value: float) -> None:
        self._console.ale_settings.set(key, float, value)

    def getBool(self, key: str | bytes) -> bool:
        return bool(self._console.ale_settings.get(key, bool))

    def setBool(self, key: str | bytes, value: bool) -> None:
        self._console.ale_settings.set(key, bool, value)

    def getString(self, key: str | bytes) -> str:
        return str(self._console.ale_settings.get(key, str))

    def setString(self, key: str | bytes, value: str) -> None:
        self._console.ale_settings.set(key, str, value)

    @staticmethod
    def setLoggerMode(mode: Any) -> None:
        """Does nothing, because the cores write no log.

        Raises:
            TypeError: it is no `LoggerMode`.
        """
        if getattr(mode, "name", None) not in ("Info", "Warning", "Error"):
            raise TypeError(f"setLoggerMode takes LoggerMode.Info, Warning or Error, got {mode!r}")

    @staticmethod
    def isSupportedROM(rom: str | PathLike[str]) -> str | None:
        """The game of a ROM file, None if no game has this ROM.

        Raises:
            AleError: there is no such file.
        """
        game = game_of_rom(rom)
        return None if game is None or game.rules is None else game.id


def game_of_rom(rom: str | PathLike[str]) -> Game | None:
    """The game of a ROM file, None if no game has this ROM.

    Raises:
        AleError: there is no such file.
    """
    try:
        return by_content(read_image(Path(rom)))
    except FileNotFoundError as error:
        raise AleError(str(error)) from None
    except ValueError:
        return None


def no_game() -> AleError:
    """The error for a method that needs a game before `loadROM` was called."""
    return AleError("no game is loaded; call loadROM first, for example with the result of roms.get_rom_path")


def _filled(name: str, read: Any, buffer: ByteArray | None) -> ByteArray:
    """A new array, or the buffer, which `read` has filled."""
    try:
        array: ByteArray = read(buffer)
    except ValueError as error:
        kind = f"{getattr(buffer, 'dtype', type(buffer).__name__)} {getattr(buffer, 'shape', '')}".strip()
        raise AleBufferError(  # ale-py's tests expect the first sentence
            f"{name}(): incompatible function arguments. The following argument types are supported: none, or "
            f"a buffer, and {str(error).replace('out must', 'it must', 1)}, got {kind}"
        ) from None
    return array


def _choose(choose: Any, number: int) -> None:
    try:
        choose(number)
    except ValueError as error:
        raise RuntimeError(str(error)) from None  # ale-py's tests accept no subclass
