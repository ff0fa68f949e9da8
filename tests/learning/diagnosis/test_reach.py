"""Findings from forks: presses that are not used though they matter, and sides that are not visited."""

from typing import Any, ClassVar

import numpy as np

from atari import Task, games
from atari.lab.labels import labels_of
from atari.learning import load_policy
from atari.learning.diagnosis.plays import Plays, play_games
from atari.learning.diagnosis.reach import player_axes, sides_not_visited, unused_presses, used_actions

PLAYER = labels_of(games["space_invaders"], "player_x")
NOOP, FIRE, RIGHT, LEFT, RIGHTFIRE, LEFTFIRE = range(6)


class Patrol:
    """Goes to and fro between two columns, firing, in Space Invaders from RAM."""

    environment: ClassVar = {"obs_type": "ram"}

    def __init__(self, low: int, high: int, right: int = RIGHTFIRE, left: int = LEFTFIRE) -> None:
        self.low, self.high, self.right, self.left = low, high, right, left
        self.rightwards = np.ones(64, np.bool_)

    def begin(self, game: str, actions: Any, lanes: Any, seeds: Any) -> None:
        self.rightwards[lanes] = True

    def __call__(self, observations: Any, lanes: Any) -> Any:
        place = PLAYER.evaluate(observations.reshape(len(observations), 128))[0][0]
        turned = np.where(self.rightwards[lanes], place < self.high, place <= self.low)
        self.rightwards[lanes] = turned
        return np.where(turned, self.right, self.left)


def patrol(*args: Any) -> Plays:
    return play_games(load_policy(Patrol(*args)), Task.of("space_invaders", obs_type="ram"), 3, seed=1)


def test_presses_that_matter_are_named() -> None:
    found = unused_presses(patrol(0, 999, RIGHT))
    assert {finding.place for finding in found} == {"LEFT", "FIRE"}
    assert all(finding.kind == "unused action" and finding.share >= 0.25 for finding in found)


def test_an_action_with_the_press_covers_it() -> None:
    plays = patrol(40, 110)
    assert used_actions(plays) == [RIGHTFIRE, LEFTFIRE]
    assert unused_presses(plays) == ()


def test_presses_without_effect_are_not_named() -> None:
    task = Task.of("breakout", full_action_space=True, max_num_frames_per_episode=2000)
    right, left, fire = 3, 4, 1

    def sweep(observations: Any) -> Any:
        sweep.calls += 1  # type: ignore[attr-defined]
        return np.full(len(observations), (fire, right, left)[sweep.calls // 9 % 3])  # type: ignore[attr-defined]

    sweep.calls = 0  # type: ignore[attr-defined]
    plays = play_games(load_policy(sweep), task, 2, seed=1)
    assert unused_presses(plays) == ()  # UP and DOWN do nothing in Breakout


def test_a_side_that_can_be_reached_is_named() -> None:
    (right,) = sides_not_visited(patrol(0, 60))
    assert (right.kind, right.place) == ("side not visited", "right")
    assert 0.3 <= right.share < 0.9


def test_no_side_of_a_whole_range_is_named() -> None:
    plays = patrol(0, 150)
    assert [(axis.label, axis.low, axis.high) for axis in player_axes(plays)] == [("player_x", "left", "right")]
    assert sides_not_visited(plays) == ()
