"""The tasks: the target of an input, and that a solver with only the observations reaches the published threshold.

A solver is a generator that is sent characters and yields actions. It gets no other information.
"""

from collections.abc import Callable, Generator
from typing import Any

import gymnasium
import numpy as np
import pytest

from atari.classic.algorithmic import (
    AlgorithmicEnv,
    CopyEnv,
    DuplicatedInputEnv,
    RepeatCopyEnv,
    ReversedAdditionEnv,
    ReverseEnv,
)

Solver = Generator[tuple[int, int, int], int, None]

LEFT, RIGHT, UP, DOWN = range(4)


def copy(blank: int) -> Solver:
    seen = yield RIGHT, 0, 0
    seen = yield LEFT, 0, 0
    while True:
        seen = yield RIGHT, 1, seen


def duplicated_input(blank: int) -> Solver:
    seen = yield RIGHT, 0, 0
    while True:
        seen = yield RIGHT, 1, seen
        seen = yield RIGHT, 0, 0


def repeat_copy(blank: int) -> Solver:
    seen = yield LEFT, 0, 0
    seen = yield RIGHT, 0, 0
    for move, back in ((RIGHT, LEFT), (LEFT, RIGHT), (RIGHT, LEFT)):
        while seen != blank:
            seen = yield move, 1, seen
        seen = yield back, 0, 0


def reverse(blank: int) -> Solver:
    seen = yield RIGHT, 0, 0
    while seen != blank:
        seen = yield RIGHT, 0, 0
    seen = yield LEFT, 0, 0
    while True:
        seen = yield LEFT, 1, seen


def addition(rows: int) -> Callable[[int], Solver]:
    """Down one column and up the next; `blank` is the base, too."""

    def solver(blank: int) -> Solver:
        seen, down, carry = (yield LEFT, 0, 0), True, 0
        seen = yield RIGHT, 0, 0
        while True:
            total = carry
            for _ in range(rows - 1):
                total += seen
                seen = yield DOWN if down else UP, 0, 0
            if seen == blank:  # past the last column
                yield LEFT, 1, carry
            carry, digit = divmod(total + seen, blank)
            seen = yield RIGHT, 1, digit
            down = not down
            if seen == blank:
                yield LEFT, 1, carry

    return solver


def play(env: gymnasium.Env[Any, Any], solver: Callable[[int], Solver]) -> float:
    """The return of one episode."""
    env = env.unwrapped  # Gymnasium's wrappers take longer than the environment
    observation, _ = env.reset()
    actions = solver(env.base)  # type: ignore[attr-defined]
    action, total, over = next(actions), 0.0, False
    while not over:
        observation, reward, terminated, truncated, _ = env.step(action)
        total, over = total + float(reward), terminated or truncated
        action = actions.send(observation) if not over else action
    return total


@pytest.mark.parametrize(
    ("env_id", "solver", "episodes"),
    [
        ("Copy-v0", copy, 380),
        ("DuplicatedInput-v0", duplicated_input, 380),
        ("RepeatCopy-v0", repeat_copy, 1500),
        ("Reverse-v0", reverse, 1550),
        ("ReversedAddition-v0", addition(2), 380),
    ],
)
def test_a_solver_reaches_the_published_threshold(env_id: str, solver: Callable[[int], Solver], episodes: int) -> None:
    env = gymnasium.make(env_id)
    env.reset(seed=0)
    returns = [play(env, solver) for _ in range(episodes)]
    assert min(returns) > 0
    assert env.unwrapped.min_length == 30  # type: ignore[attr-defined]
    assert env.spec is not None
    assert env.spec.reward_threshold is not None
    assert np.mean(returns[-100:]) >= env.spec.reward_threshold > np.mean(returns[:100])


def test_three_rows_cannot_be_read_in_the_published_time_but_in_a_step_more() -> None:
    def final_length(**options: int) -> int:
        env = gymnasium.make("ReversedAddition3-v0", **options)  # type: ignore[arg-type]
        env.reset(seed=0)
        for _ in range(400):
            play(env, addition(3))
        return int(env.unwrapped.min_length)  # type: ignore[attr-defined]

    assert final_length() <= 4
    assert final_length(steps_per_column=3) == 30


@pytest.mark.parametrize(
    ("env", "given", "target"),
    [
        (CopyEnv(), "ABCDE", "ABCDE"),
        (DuplicatedInputEnv(), "AAAACC", "AAC"),
        (DuplicatedInputEnv(duplication=3), "AAABBB", "AB"),
        (RepeatCopyEnv(), "ABC", "ABCCBAABC"),
        (ReverseEnv(), "AAB", "BAA"),
        (ReverseEnv(base=3), "C", "C"),
        (ReversedAdditionEnv(), "112\n202", "0211"),
        (ReversedAdditionEnv(), "11\n11", "22"),
        (ReversedAdditionEnv(rows=3, base=10), "999\n999\n999", "7992"),
        (ReversedAdditionEnv(base=2), "1\n1", "01"),
        (ReversedAdditionEnv(rows=4, base=2), "1\n1\n1\n1", "001"),
        (ReversedAdditionEnv(base=1), "00\n00", "00"),
    ],
)
def test_the_target_of_an_input(env: AlgorithmicEnv, given: str, target: str) -> None:
    assert env.reset(options={"input": given})[1]["target"] == target


def test_inputs_are_as_long_as_they_should_be_and_of_all_characters() -> None:
    for env in (CopyEnv(min_length=7), RepeatCopyEnv(min_length=7), ReversedAdditionEnv(min_length=7)):
        inputs = [env.reset(seed=seed)[1]["input"].split("\n") for seed in range(60)]
        assert {len(line) for lines in inputs for line in lines} == {7, 8, 9}
        assert {character for lines in inputs for line in lines for character in line} == set(env.alphabet[: env.base])


@pytest.mark.parametrize(("duplication", "lengths"), [(1, {5, 6, 7}), (2, {4, 6}), (3, {3, 6}), (9, {9})])
def test_duplicated_inputs_are_whole_and_fit(duplication: int, lengths: set[int]) -> None:
    env = DuplicatedInputEnv(duplication=duplication, min_length=5)
    inputs = [env.reset(seed=seed)[1]["input"] for seed in range(40)]
    assert {len(text) for text in inputs} == lengths
    for text in inputs:
        assert text == "".join(letter * duplication for letter in text[::duplication])
