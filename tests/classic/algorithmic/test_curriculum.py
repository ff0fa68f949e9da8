"""Inputs grow after enough solved episodes in a row, and only then."""

from collections.abc import Callable

import pytest

from atari.classic.algorithmic import CopyEnv, ReverseEnv
from atari.classic.algorithmic.environment import MAX_LENGTH, Curriculum


def test_a_window_of_solved_episodes_makes_it_grow_by_one() -> None:
    curriculum = Curriculum(2, window=3)
    lengths = []
    for solved in (True, True, True, True, True, False, True, True, True):
        curriculum.record(solved)
        lengths.append(curriculum.length)
    assert lengths == [2, 2, 3, 3, 3, 3, 3, 3, 4]


def test_it_stops_at_the_greatest_length() -> None:
    curriculum = Curriculum(MAX_LENGTH - 1, window=1)
    for _ in range(5):
        curriculum.record(True)
    assert curriculum.length == MAX_LENGTH == 30


def play(env: CopyEnv | ReverseEnv, character: int) -> None:
    env.reset(options={"input": "A"})
    env.step((1, 1, character))


@pytest.mark.parametrize(("env", "window"), [(CopyEnv(), 10), (ReverseEnv(), 50)])
def test_an_environment_grows_at_the_reset_after_its_window(env: CopyEnv | ReverseEnv, window: int) -> None:
    start = env.min_length
    for _ in range(window):
        play(env, 0)
    assert env.min_length == start
    assert env.reset()[1]["min_length"] == env.min_length == start + 1


def give_up(env: CopyEnv) -> None:
    env.reset()
    env.step((1, 0, 0))


@pytest.mark.parametrize("spoil", [lambda env: play(env, 1), give_up], ids=["a mistake", "giving up"])
def test_an_episode_that_is_not_solved_starts_the_count_again(spoil: Callable[[CopyEnv], None]) -> None:
    env = CopyEnv()
    for unsolved in (spoil, lambda env: play(env, 0)):
        for _ in range(9):
            play(env, 0)
        unsolved(env)
    assert env.reset()[1]["min_length"] == 3
    for _ in range(9):
        play(env, 0)
    spoil(env)
    assert env.reset()[1]["min_length"] == 3


def test_resets_alone_do_not_count() -> None:
    env = CopyEnv()
    for _ in range(10):
        play(env, 0)
        env.reset()
        env.reset()
    assert env.min_length == 3


def test_a_seed_starts_from_the_first_length() -> None:
    env = CopyEnv(min_length=4)
    for _ in range(21):
        play(env, 0)
    assert env.min_length == 6
    assert env.reset(seed=0)[1]["min_length"] == 4


def test_two_environments_grow_apart() -> None:
    one, other = CopyEnv(), CopyEnv()
    for _ in range(11):
        play(one, 0)
    other.reset()
    assert (one.min_length, other.min_length) == (3, 2)
