"""A game as text, for programs in C++ that play without Python: `play` and `goldens`."""

from typing import Any

import atari
from atari.cores import compiled
from atari.games.game import Game


def game_words(game: Game) -> str:
    """The game as the native core describes it to its emulator: a line an argument, its name first, then its values."""
    image = atari.roms.find(game).read_bytes()
    values = {**compiled.definition(game, image), "minimal_actions": game.minimal_actions}
    return "".join(f"{name} {words(value)}\n" for name, value in values.items())


def words(value: Any) -> str:
    """A text, bytes, or a number or truth value or a sequence of numbers, as words."""
    if isinstance(value, bytes):
        return value.hex()
    if isinstance(value, str):
        return value
    return " ".join(str(int(number)) for number in (value if isinstance(value, list | tuple) else [value]))
