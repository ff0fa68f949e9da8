"""`fingerprint`: a hash of a game definition, equal for equal rules of play."""

import hashlib
import json
from functools import cache
from pathlib import Path

from atari.games.catalog import games
from atari.games.game import Game
from atari.games.toml_file import read_toml

_FOLDER = Path(__file__).parent / "data"
_DESCRIPTIVE = ("title", "notes", "ram", "rom")
"""Tables of a game file that do not change how the game is played. The ROM has its own MD5."""


def fingerprint(game: Game) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of the parts of a game definition that concern play.

    Titles, notes and the names of RAM bytes do not count.

    Example:
        >>> import atari
        >>> from atari.games.fingerprint import fingerprint
        >>> len(fingerprint(atari.games["pong"]))
        16
    """
    if game.file is None and games.get(game.id) is game:
        return _of_file(_FOLDER / f"{game.id}.toml", 0)
    if game.file is not None and game.file.exists():
        return _of_file(game.file, game.file.stat().st_mtime_ns)
    parts = (game.screen, game.controllers, game.minimal_actions, game.legal_actions, game.starting_actions)
    return _digest(repr((*parts, game.modes, game.default_mode, game.difficulties, game.rules, game.multiplayer)))


@cache
def _of_file(path: Path, changed: int) -> str:
    tables = read_toml(path, "a game definition")
    decisive = {name: table for name, table in tables.items() if name not in _DESCRIPTIVE}
    return _digest(json.dumps(decisive, sort_keys=True))


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:16]
