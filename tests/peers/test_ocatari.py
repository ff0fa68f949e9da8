"""OCAtari's objects: it reads positions from RAM too, by code of its own.

They are compared in the same games: ROM, seed and actions are the same, and so is the RAM, which OCAtari gets from ale-py.
"""

import fnmatch
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from ocatari_names import DIFFERENT, NAMES

import atari
from atari.games.objects import GameObject
from atari.lab import Ram

pytestmark = pytest.mark.peers

TOLERANCE = 3
"""Pixels of difference, in x and in y, up to which two positions agree: the edges of a figure move with its poses."""

SHARE = 0.9
"""Of the pairs of objects in the frames of a game, at least how many agree, where `DIFFERENT` has no less."""

FRAMES, EVERY = 800, 5

Place = tuple[int, int, int, int]


def squeezed(name: str) -> str:
    return name.replace("_", "").lower()


class Theirs:
    """OCAtari's objects of a game, by category."""

    def __init__(self, game: str) -> None:
        core = pytest.importorskip("ocatari.core")
        self._ram = pytest.importorskip("ocatari.ram.extract_ram_info")
        self._name = {squeezed(name): name for name in core.AVAILABLE_GAMES}[squeezed(game)]
        self.reset()

    def reset(self) -> None:
        self._objects = self._ram.init_objects(self._name, False)

    def read(self, ram: Any) -> dict[str, list[Place]]:
        # its sums are those of numpy 1, in which a byte minus a number may be negative
        self._ram.detect_objects_ram(self._objects, ram.astype(np.int64), self._name, False)
        found: dict[str, list[Place]] = {}
        for each in self._objects:
            if each and each.category != "NoObject":
                x, y, width, height = map(int, each.xywh)
                found.setdefault(each.category, []).append((x, y, width, height))
        return found


def pairs(game: str, ours: list[GameObject], theirs: dict[str, list[Place]]) -> Iterator[tuple[GameObject, Place]]:
    """Each of our objects with the nearest of theirs in the categories of `NAMES`; none if they have none."""
    for part in NAMES[game].split():
        pattern, _, categories = part.partition("=")
        places = [place for category in categories.split("|") for place in theirs.get(category, [])]
        for each in ours:
            if places and fnmatch.fnmatchcase(each.name, pattern):
                yield each, min(places, key=lambda place: distance(each, place))


def distance(ours: GameObject, place: Place) -> int:
    """The larger of the differences in x and y; an axis that we have no label of does not count."""
    x = 0 if ours.x is None else abs(ours.x - place[0])
    y = 0 if ours.y is None else abs(ours.y - place[1])
    return max(x, y)


@pytest.mark.parametrize("game", NAMES)
def test_positions_are_those_of_ocatari(game: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs = Theirs(game)
    env = atari.AtariEnv(game, frameskip=1, repeat_action_probability=0.0, obs_type="ram")
    peer = atari.AtariEnv(game, frameskip=1, repeat_action_probability=0.0, obs_type="ram", core="ale")
    observation, expected = env.reset(seed=0)[0], peer.reset(seed=0)[0]
    env.action_space.seed(0)
    ram, agree, compared = Ram(env), 0, 0
    for frame in range(FRAMES):
        if frame % 10 == 0:
            action = env.action_space.sample()
        observation, _, terminated, truncated, _ = env.step(action)
        expected, *_ = peer.step(action)
        if terminated or truncated:
            observation, expected = env.reset()[0], peer.reset()[0]
            theirs.reset()
        assert (observation == expected).all(), frame
        if frame % EVERY == 0:
            for each, place in pairs(game, ram.objects(), theirs.read(expected)):
                compared += 1
                agree += distance(each, place) <= TOLERANCE
    assert compared >= 20
    assert agree >= DIFFERENT.get(game, SHARE) * compared, (agree, compared)
    env.close()
    peer.close()
