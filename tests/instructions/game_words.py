"""A game as text, for programs in C++ that play without Python: `play` and `goldens`."""

import atari
from atari.cores import compiled
from atari.games.game import Game
from atari.web.table import words


def game_words(game: Game) -> str:
    """The game as the native core describes it to its emulator: a line an argument, its name first, then its values."""
    image = atari.roms.find(game).read_bytes()
    values = {**compiled.definition(game, image), "image": image.hex(), "minimal_actions": game.minimal_actions}
    return "".join(f"{name} {words(value)}\n" for name, value in values.items())
