"""Findings from the actions of plays: where they become random, and where they are a loop."""

from typing import Any

import numpy as np
import pytest

from atari import Task
from atari.learning.diagnosis.habits import loop, random_from
from atari.learning.diagnosis.plays import Play, Plays

NAMES = ("NOOP", "FIRE", "RIGHT", "LEFT", "RIGHTFIRE", "LEFTFIRE")


def made(games: list[tuple[Any, Any]]) -> Plays:
    """Plays with these actions and rewards."""
    plays = []
    for actions, rewards in games:
        steps = len(actions)
        rewards = np.asarray(rewards, np.int32)
        still = np.full(steps, 3, np.int16)
        rams = np.zeros((steps, 128), np.uint8)
        acts = np.asarray(actions, np.uint8)
        plays.append(Play(0, float(rewards.sum()), 4 * steps, False, 3, acts, rewards, still, rams, None, ()))
    other: Any = None
    return Plays(Task.of("space_invaders"), NAMES, other, 0.0, 0, other, other, tuple(plays))


def structured(rng: np.random.Generator, steps: int) -> Any:
    """Actions as an agent chooses them: held for some steps, some of them more often."""
    return np.repeat(rng.choice(6, p=[0.05, 0.3, 0.2, 0.15, 0.2, 0.1], size=steps), rng.integers(1, 5, steps))[:steps]


def rewards(rng: np.random.Generator, steps: int) -> Any:
    return 10 * (rng.random(steps) < 0.05)


@pytest.mark.parametrize("seed", range(3))
def test_random_actions_begin_at_a_score(seed: int) -> None:
    rng = np.random.default_rng(seed)
    games = []
    for length in (500, 700, 900, 800):
        actions, gains = structured(rng, length), rewards(rng, length)
        after = np.cumsum(gains) - gains >= 100
        games.append((np.where(after, rng.integers(6, size=length), actions), gains))
    finding = random_from(made(games))
    assert finding is not None
    assert finding.place == f"{finding.number} points"
    assert abs((finding.number or 0) - 100) <= 10


def test_random_actions_begin_at_a_step() -> None:
    rng = np.random.default_rng(4)
    games = []
    for _ in range(4):
        actions = structured(rng, 800)
        actions[300:] = rng.integers(6, size=500)
        games.append((actions, rewards(rng, 800)))
    finding = random_from(made(games))
    assert finding is not None
    assert finding.place.startswith("step ")
    assert abs((finding.number or 0) - 300) <= 10


@pytest.mark.parametrize("seed", range(3))
def test_an_agent_is_not_random_because_its_actions_vary(seed: int) -> None:
    rng = np.random.default_rng(seed)
    assert random_from(made([(structured(rng, 800), rewards(rng, 800)) for _ in range(4)])) is None


def test_random_actions_in_one_game_of_many_are_no_finding() -> None:
    rng = np.random.default_rng(5)
    games = [(structured(rng, 800), rewards(rng, 800)) for _ in range(8)]
    games[0] = (rng.integers(6, size=800), games[0][1])
    assert random_from(made(games)) is None


def looping(rng: np.random.Generator, at: int, cycle: list[int], rewarded: bool = False) -> tuple[Any, Any]:
    actions, gains = structured(rng, 900), rewards(rng, 900)
    actions[at:] = np.resize(cycle, 900 - at)
    gains[at:] *= rewarded
    return actions, gains


def test_a_loop_begins_at_a_step() -> None:
    rng = np.random.default_rng(1)
    games = [looping(rng, 400, [2, 3, 3, 0]) for _ in range(5)]
    for actions, _ in games:
        actions[600] = 1  # a random action does not end a cycle
    finding = loop(made(games))
    assert finding is not None
    assert finding.place.startswith("step ")
    assert abs((finding.number or 0) - 400) <= 8
    assert finding.share == pytest.approx(5 / 9, abs=0.02)


def test_a_loop_begins_at_a_score() -> None:
    rng = np.random.default_rng(2)
    games = []
    for _ in range(6):
        actions, gains = structured(rng, 900), rewards(rng, 900)
        at = int(np.flatnonzero(np.cumsum(gains) >= 150)[0]) + 1
        actions[at:], gains[at:] = np.resize([2, 3, 3, 0, 5], 900 - at), 0
        games.append((actions, gains))
    finding = loop(made(games))
    assert finding is not None
    assert finding.place == "150 points"


def test_cycles_that_get_rewards_are_no_loop() -> None:
    rng = np.random.default_rng(3)
    assert loop(made([looping(rng, 400, [2, 3, 3, 0], rewarded=True) for _ in range(5)])) is None


def test_a_wait_that_other_games_survive_is_no_loop() -> None:
    rng = np.random.default_rng(3)
    games = [looping(rng, at, [0]) for at in (400, 400, 400, 450, 450)]
    assert loop(made(games)) is not None
    for actions, gains in games[:3]:
        actions[890:], gains[895] = 1, 10  # these go on to get a reward
    assert loop(made(games)) is None


def test_a_cycle_in_a_single_game_of_many_is_no_finding() -> None:
    rng = np.random.default_rng(3)
    games = [(structured(rng, 900), rewards(rng, 900)) for _ in range(20)]
    games[0] = looping(rng, 400, [2, 3, 3, 0])
    assert loop(made(games)) is None
