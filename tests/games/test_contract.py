"""Game definitions of this package keep the contract of `atari.testing.check_game_file`: games of different kinds.

Paddles, PAL, cartridges with banks and RAM, modes that are selected by playing, positions of many objects, lives that
fall and rise, rewards below zero, long names of bytes, and the example of a game of one's own.
"""

from pathlib import Path

import pytest

import atari
from atari.testing import check_game_file

GAMES = "pong breakout adventure double_dunk klax ms_pacman pitfall2 skiing solaris video_chess".split()


@pytest.mark.parametrize("game", GAMES)
def test_games_of_this_package(game: str) -> None:
    check_game_file(atari.games[game], steps=300)


def test_the_example() -> None:
    folder = Path(__file__).parents[2] / "examples" / "catch"
    check_game_file(folder / "catch.toml", rom=folder / "catch.bin")
