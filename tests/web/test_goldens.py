"""The core in WebAssembly gives the golden values of ale-py: RAM, screen, sound, rewards, lives and frame numbers."""

import json

import pytest
from platforms.goldens_file import golden_values, played_game
from web_tools import GAMES, TESTS, image, needs_core, node

import atari
from atari.web.table import core_text

GOLDENS = json.loads((TESTS / "conformance" / "goldens.json").read_text())["games"]


@needs_core
@pytest.mark.parametrize("name", [name for name in GOLDENS if name in GAMES])
def test_goldens(name: str) -> None:
    game, goldens = played_game(name, GOLDENS[name]), golden_values(GOLDENS[name])
    seen = node(
        "play_goldens.mjs",
        core=core_text(game),
        image=image(name),
        actions=[int(action) for action in game.minimal_actions],
        stand_in=bool(GOLDENS[name]["stand_in"]),
        goldens=goldens,
    )
    assert seen == goldens


def test_every_game_has_goldens() -> None:
    assert set(GOLDENS) == set(atari.games)
