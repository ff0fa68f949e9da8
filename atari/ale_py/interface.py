"""`ALEInterface`: games loaded from ROM files, under the method names of ale-py's class."""

from os import PathLike, fspath

import atari._emulator as _emulator
from atari.base.validation import AleError
from atari.cores import NativeCore
from atari.cores.ale_actions import AleEnum
from atari.cores.ale_game import AleGame
from atari.cores.ale_interface import AleConsole, AleInterface, AleSettings, no_game
from atari.cores.core import Core
from atari.games.catalog import games

ALEState = _emulator.State
"""The class of the states that `ALEInterface.cloneState` returns."""


class LoggerMode(AleEnum):
    """The messages that ale-py prints. Nothing is printed here.

    Example:
        >>> from atari.ale_py import ALEInterface, LoggerMode
        >>> ALEInterface.setLoggerMode(LoggerMode.Error)
    """

    Info = 0
    Warning = 1
    Error = 2


class ALEInterface(AleInterface):
    """A game, loaded from a ROM file by `loadROM`. Settings before the first load apply to it.

    Raises:
        AleError: a method needs a game before `loadROM` was called.

    Example:
        >>> from atari.ale_py import ALEInterface, roms
        >>> ale = ALEInterface()
        >>> ale.loadROM(roms.get_rom_path("pong"))
        >>> ale.reset_game()
        >>> len(ale.getMinimalActionSet()), ale.getRAM().shape
        (6, (128,))
    """

    _console: "_Console"

    def __init__(self) -> None:
        super().__init__(_Console())

    def loadROM(self, rom: str | PathLike[str]) -> None:
        """Load a game, with the settings.

        Raises:
            AleError: there is no such file, or it is the ROM of no game.
        """
        self._console.load(id_of_rom(rom), rom)


def id_of_rom(rom: str | PathLike[str]) -> str:
    """The id of the game of a ROM file.

    Raises:
        AleError: there is no such file, or it is the ROM of no game.
    """
    game = ALEInterface.isSupportedROM(rom)
    if game is None:
        raise AleError(
            f"{fspath(rom)} is the ROM of no game of ale-py; `atari roms identify` says what it is, and "
            "atari.register_game registers a game of your own"
        )
    return game


class _Console(AleConsole):
    """The console of an `ALEInterface`: its settings, and the game that was loaded last."""

    def __init__(self) -> None:
        self.ale_settings = AleSettings()
        self._game: AleGame | None = None

    @property
    def emulated(self) -> Core:
        """The emulator core of the game."""
        if self._game is None:
            raise no_game()
        return self._game.emulated

    def load_game(self) -> None:
        """Load the game again; `ALEInterface.loadROM` does so itself."""

    def load(self, game: str, rom: str | PathLike[str]) -> None:
        self._game = AleGame(
            NativeCore, games[game], self.ale_settings, mode=None, difficulty=None, rom=rom, interventions=()
        )
