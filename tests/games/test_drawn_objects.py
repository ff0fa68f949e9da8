"""Objects that labels list are on the screen, in their rows and columns: at the start of each game, and in play."""

import numpy as np
import pytest
from drawn_objects import Play, Probe, undecided

import atari
from atari.games.objects import constants, positions
from atari.lab import Ram

FIXED, MOVING, FEW = 4, 9, 4
"""Pixels of difference, for objects with a constant row or column and for others; a shot moves nine in a frame. Fewer
probes of an object than the third number decide nothing."""

UNMOVED = {"darkchambers", "klax", "tetris"}
"""Games that draw nothing elsewhere in the next frames after a change of a byte."""

GAMES = tuple(game.id for game in atari.games.playable() if positions(game.ram_labels))


@pytest.mark.parametrize("game", GAMES)
def test_the_objects_of_the_first_frames_are_drawn(game: str) -> None:
    play = Play(atari.games[game], seed=0)
    play.frames(20)
    found = dict(play.faults())
    play.close()
    assert not found.keys() - undecided().get(game, {}).keys(), found


@pytest.mark.parametrize("game", sorted({*GAMES} - UNMOVED))
def test_objects_are_drawn_in_their_rows_and_columns(game: str) -> None:
    play = Play(atari.games[game], seed=2)
    play.frames(80)
    offsets = play.offsets()
    play.close()
    assert any(offsets.values())
    labels = positions(atari.games[game].ram_labels)
    for (name, axis), found in offsets.items():
        if len(found) >= FEW and name not in undecided().get(game, {}):
            limit = FIXED if constants(labels[name]) else MOVING
            assert abs(float(np.median(found))) <= limit, (name, axis, found)


def test_what_is_undecided_is_an_object() -> None:
    for game, objects in undecided().items():
        assert objects.keys() <= set(positions(atari.games[game].ram_labels))
        assert all(reason.startswith(("drawn: ", "undecided: ")) for reason in objects.values())


def test_seaquest_begins_without_enemies() -> None:
    env = atari.AtariEnv("seaquest", repeat_action_probability=0.0)
    env.reset(seed=0)
    for _ in range(10):
        env.step(0)
    assert {one.name for one in Ram(env).objects()} == {"player"}


@pytest.mark.parametrize(
    ("game", "name", "frames"),
    [("chopper_command", "player", 400), ("gopher", "enemy", 200), ("seaquest", "player", 60)],
)
def test_drawn_objects_are_listed(game: str, name: str, frames: int) -> None:
    play = Play(atari.games[game], seed=1)
    play.frames(frames)
    seen = Probe(play.game, play.generator).look(play.core, name)
    play.close()
    assert (seen.listed, seen.moves, seen.leaves) == (True, True, True)
