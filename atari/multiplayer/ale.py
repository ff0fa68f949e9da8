"""`ALEInterface`: games of several players under the method names of Multi-Agent-ALE's class."""

from collections.abc import Mapping, Sequence
from os import PathLike, fsdecode
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

import atari._emulator as _emulator
from atari.base.validation import AleError
from atari.cores import ByteArray
from atari.cores.ale_interface import AleConsole, AleInterface, AleSettings, game_of_rom, no_game
from atari.games.players import choose_mode, rules_of
from atari.multiplayer.core import MultiplayerCore

Integers = npt.NDArray[np.int32]
Text = str | bytes


class Logger:
    """The levels of `setLoggerMode`, with Multi-Agent-ALE's numbers."""

    Info = 0
    Warning = 1
    Error = 2


class MultiplayerAle(AleInterface):
    """The methods of Multi-Agent-ALE's `ALEInterface` for a `MultiplayerCore`.

    Actions, rewards and lives are int32 arrays with an element for each player. States need no `deleteState`. Errors
    are exceptions where Multi-Agent-ALE ends the process.
    """

    # ruff: noqa: D102 - the names are Multi-Agent-ALE's, one line each

    __slots__ = ("_saved",)

    Logger = Logger

    _console: "Console"

    def __init__(self, console: "Console") -> None:
        super().__init__(console)
        self._saved: list[Any] = []

    @property
    def _core(self) -> Any:  # a MultiplayerCore, or one that is recorded
        return self._console.emulated

    def act(self, action: Sequence[int] | npt.NDArray[Any]) -> Integers:  # type: ignore[override]
        return np.array(self._core.act_players([*action]), np.int32)

    def numPlayersActive(self) -> int:
        return int(self._core.players)

    def lives(self) -> int:
        """Lives of player 1."""
        return int(self._core.player_lives[0])

    def allLives(self) -> Integers:
        return np.array(self._core.player_lives, np.int32)

    def isSupportedRom(self) -> bool:
        return rules_of(self._core.game) is not None

    def loadROM(self, rom_file: Text | PathLike[str]) -> None:
        super().loadROM(fsdecode(rom_file))

    def getLegalActionSet(self) -> Integers:  # type: ignore[override]
        return np.arange(18, dtype=np.int32)

    def getMinimalActionSet(self) -> Integers:  # type: ignore[override]
        return np.array(rules_of(self._core.game).minimal_actions, np.int32)

    def getAvailableModes(self, num_players: int = 1) -> Integers:  # type: ignore[override]
        """The modes for this number of players; none for 1, because `atari.ale_py.ALEInterface` plays those games."""
        return np.array(sorted(rules_of(self._core.game).modes.get(num_players, ())), np.int32)

    def getAvailableDifficulties(self) -> Integers:  # type: ignore[override]
        return np.array(rules_of(self._core.game).difficulties, np.int32)

    def getScreenDims(self) -> tuple[int, int]:
        """(width, height)."""
        height, width = self._core.game.screen.shape
        return width, height

    def getScreen(self, screen_data: ByteArray | None = None) -> ByteArray:
        """The palette indices of the pixels, (height * width,), or `screen_data`, which is filled."""
        return _fill(super().getScreen().reshape(-1), screen_data)

    def getScreenRGB(self, screen_data: ByteArray | None = None) -> ByteArray:
        return super().getScreenRGB(screen_data)

    def getScreenGrayscale(self, screen_data: ByteArray | None = None) -> ByteArray:
        """The luminances of the pixels, (height, width, 1), or `screen_data`, which is filled."""
        return _fill(super().getScreenGrayscale()[..., None], screen_data)

    def getRAM(self, ram: ByteArray | None = None) -> ByteArray:
        return super().getRAM(ram)

    def setRAM(self, memory_index: int, value: int) -> None:
        super().setRAM(memory_index, value)

    def saveScreenPNG(self, filename: Text | PathLike[str]) -> None:
        super().saveScreenPNG(fsdecode(filename))

    def saveState(self) -> None:
        """Put the state on a stack."""
        self._saved.append(self.cloneSystemState())

    def loadState(self) -> None:
        """Continue from the last state that `saveState` has put on the stack, and remove it there."""
        if not self._saved:
            raise AleError("no state is saved; call saveState first")
        self.restoreState(self._saved.pop())

    def deleteState(self, state: _emulator.State) -> None:
        """Nothing, because Python releases states."""

    def encodeStateLen(self, state: _emulator.State) -> int:
        return len(state.serialize())

    def encodeState(self, state: _emulator.State, buf: ByteArray | None = None) -> ByteArray:
        """The bytes of a state, uint8, or `buf`, which is filled."""
        return _fill(np.frombuffer(state.serialize(), np.uint8), buf)

    def decodeState(self, serialized: ByteArray) -> _emulator.State:
        """The state of bytes that `encodeState` returned.

        Raises:
            ValueError: they are no such bytes.
        """
        try:
            data = np.asarray(serialized, np.uint8)
        except (OverflowError, TypeError, ValueError):
            raise ValueError(f"decodeState takes the bytes that encodeState returned, got {serialized!r:.80}") from None
        return _emulator.State(data.tobytes())

    def getString(self, key: Text) -> bytes:  # type: ignore[override]
        return super().getString(key).encode()

    def setString(self, key: Text, value: Text) -> None:
        super().setString(key, fsdecode(value))

    @staticmethod
    def setLoggerMode(mode: int | str) -> None:
        """Does nothing, because the cores write no log.

        Raises:
            TypeError: it is no level of `Logger`, and not "info", "warning" or "error".
        """
        if mode not in (Logger.Info, Logger.Warning, Logger.Error, "info", "warning", "error"):
            raise TypeError(f"setLoggerMode takes 'info', 'warning', 'error', 0, 1 or 2, got {mode!r}")


class ALEInterface(MultiplayerAle):
    """A game of two to four players, loaded from a ROM file by `loadROM`. Settings before the load apply to it.

    `loadROM` chooses the mode of PettingZoo's environment, and `setMode` another one, for any number of players.

    Raises:
        AleError: a method needs a game before `loadROM` was called, or the file is no ROM of a game of several players.

    Example:
        >>> from atari.ale_py import roms
        >>> from atari.multiplayer import ALEInterface
        >>> ale = ALEInterface()
        >>> ale.setInt(b"random_seed", 1)
        >>> ale.loadROM(roms.get_rom_path("pong"))
        >>> ale.setMode(6)
        >>> ale.reset_game()
        >>> ale.numPlayersActive(), ale.act([0, 1, 3, 4]).tolist()
        (4, [0, 0, 0, 0])
    """

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__(Console(SimpleNamespace(core=None), {"random_seed": 0}, {}))

    def loadROM(self, rom_file: Text | PathLike[str]) -> None:
        rom = fsdecode(rom_file)
        game = game_of_rom(rom)
        if game is None or game.multiplayer is None:
            raise AleError(
                f"{rom} is the ROM of no game of several players; atari.ale_py.ALEInterface plays the games of one"
            )
        self._console.load(MultiplayerCore(game, rom=rom))

    def setMode(self, mode: int) -> None:
        """Play this mode from the next reset on; a game of another number of players is loaded at once."""
        core = self._core
        try:
            _, players = choose_mode(core.game, mode, None)
        except ValueError as error:
            raise AleError(str(error)) from None
        if players == core.players:
            super().setMode(mode)
        else:
            self._console.load(MultiplayerCore(core.game, rom=core.rom, mode=mode))


class Console(AleConsole):
    """The console of a `MultiplayerAle`: the core of an owner, and the settings for its next load.

    Args:
        owner: an object with a `core`, such as a `MultiplayerEnv`.
        settings: the settings of that core.
        without: settings that the owner does not have, each with what a user does instead.
    """

    def __init__(self, owner: Any, settings: Mapping[str, Any], without: Mapping[str, str]) -> None:
        self._owner, self._without = owner, {**_WITHOUT, **without}
        self.ale_settings = AleSettings(**settings)
        self._loaded = AleSettings(**settings).core_options()  # the settings of the core

    @property
    def emulated(self) -> Any:
        """The core, which may be a recorded one."""
        if self._owner.core is None:
            raise no_game()
        return self._owner.core

    def load_game(self) -> None:
        """Load the game again, with the settings.

        Raises:
            AleError: a setting has changed, and the core is recorded, or the owner does not have the setting.
        """
        self.load(self.emulated)

    def load(self, core: Any) -> None:
        """Give the owner this core, with the settings; see `load_game`."""
        wanted = self.ale_settings.core_options()
        known = self._loaded if core is self._owner.core else _NEW
        changed = {name: value for name, value in wanted.items() if value != known[name]}
        for name in self._without.keys() & changed.keys():
            raise AleError(f"{name}={changed[name]} has no effect here; {self._without[name]}")
        if changed and not isinstance(core, MultiplayerCore):
            raise AleError(f"the core is recorded, and {min(changed)} would be lost; set it before RecordReplay begins")
        if changed:
            core = core.with_options(**{_FIELDS[name]: value or None for name, value in changed.items()})
        core.seed(self.ale_settings.seed())
        self._owner.core, self._loaded, self.ale_settings.stale = core, wanted, False


_NEW = AleSettings(repeat_action_probability=0.0).core_options()
"""The settings of a new `MultiplayerCore`."""

_FIELDS = {
    "repeat_action_probability": "repeat_action_probability",
    "frame_skip": "frameskip",
    "max_num_frames_per_episode": "max_num_frames_per_episode",
}
"""The fields of a task by the names of the settings."""

_WITHOUT = {
    "color_averaging": "games of several players have no colour averaging",
    "sound": "make MultiplayerCore or MultiplayerEnv with sound=True",
}


def _fill(values: ByteArray, buffer: ByteArray | None) -> ByteArray:
    """The values, or the buffer, which is filled with them."""
    if buffer is None:
        return np.array(values)
    if not isinstance(buffer, np.ndarray) or buffer.dtype != np.uint8:
        raise TypeError(f"a buffer is a uint8 array, got {getattr(buffer, 'dtype', type(buffer).__name__)}")
    if buffer.size != values.size:
        raise ValueError(f"the buffer must have {values.size} elements, got the shape {buffer.shape}")
    buffer[...] = values.reshape(buffer.shape)
    return buffer
