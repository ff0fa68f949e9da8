"""`ale_py.roms`: the ROM files by the names of their games."""

import warnings
from pathlib import Path

from atari.games.catalog import games
from atari.roms import find


def get_rom_path(name: str) -> Path | None:
    """The path of the ROM file of a game, such as "pong".

    Returns:
        The path; None, with a warning, if there is no such game.

    Raises:
        FileNotFoundError: no file of the game was found.
    """
    if name not in games:
        warnings.warn(f"{games.unknown(name)}, so get_rom_path returns None", stacklevel=2)
        return None
    return find(name)


def get_all_rom_ids() -> list[str]:
    """The names of all games with a ROM file, in alphabetical order."""
    return list(games)
