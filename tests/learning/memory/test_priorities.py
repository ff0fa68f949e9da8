"""Sampling by priority, beside the definition of Schaul et al. 2016."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atari.learning import ReplayMemory


def filled(steps: int, lanes: int = 1, *, ends: tuple[int, ...] = (), exponent: float = 0.6, **options) -> ReplayMemory:
    """A memory in which the reward of a step is its row."""
    memory = ReplayMemory(options.pop("capacity", 1000), lanes, (2, 2), priority_exponent=exponent, seed=0, **options)
    frames = np.zeros((lanes, 2, 2), np.uint8)
    memory.reset(frames)
    for row in range(steps):
        ended = np.full(lanes, row in ends)
        memory.add(np.zeros(lanes, int), np.full(lanes, row, float), ended, ~ended & False, observations=frames)
    return memory


def test_weights_are_exact_and_draws_stratified() -> None:
    memory = filled(200)
    priorities = np.random.default_rng(0).random(200) ** 3
    priorities[::7] = 0
    memory.update_priorities(np.arange(200), priorities)
    mass = priorities**0.6
    probability = mass / mass.sum()
    edges = np.concatenate([[0], np.cumsum(mass)])
    for beta in (0.0, 0.4, 1.0):
        batch = memory.sample(64, beta=beta)
        weights = (200 * probability[batch.indices]) ** -beta
        np.testing.assert_allclose(batch.weights, weights / weights.max(), rtol=1e-6)
        for stratum, index in enumerate(batch.indices):
            low, high = stratum / 64 * edges[-1], (stratum + 1) / 64 * edges[-1]
            assert edges[index] < high + 1e-9
            assert edges[index + 1] > low - 1e-9
            assert priorities[index] > 0


def test_frequencies_are_the_probabilities() -> None:
    memory = filled(50, exponent=1.0)
    priorities = np.arange(50.0)
    memory.update_priorities(np.arange(50), priorities)
    counts = np.bincount(np.concatenate([memory.sample(100, beta=0.5).indices for _ in range(1000)]), minlength=50)
    expected = priorities / priorities.sum() * 100_000
    assert counts[0] == 0
    assert (np.abs(counts - expected) < 6 * np.sqrt(expected + 1)).all()


def test_uniform_frequencies() -> None:
    memory = filled(50, lanes=3, ends=(10, 30))
    wanted = {index for index in range(150) if index // 3 not in (11, 31)}
    counts = np.bincount(np.concatenate([memory.sample(100).indices for _ in range(1000)]), minlength=150)
    assert set(np.flatnonzero(counts)) == wanted
    expected = 100_000 / len(wanted)
    assert (np.abs(counts[sorted(wanted)] - expected) < 6 * np.sqrt(expected)).all()


def test_steps_within_the_reach_of_n_are_not_drawn() -> None:
    memory = filled(100, ends=(96,))
    memory.update_priorities(np.array([95, 96, 98, 99]), np.full(4, 1e6))
    drawn = set(np.concatenate([memory.sample(32, n=3, beta=1.0).indices for _ in range(50)]))
    assert {95, 96} <= drawn
    assert not drawn & {97, 98, 99}  # 97 is the ignored step; 98 and 99 have no third step yet
    assert 99 in memory.sample(32, beta=1.0).indices  # its priority has not changed


def test_priorities_of_overwritten_steps_have_no_effect() -> None:
    memory = filled(25, exponent=1.0, capacity=10)
    memory.update_priorities(np.arange(25), np.where(np.arange(25) < 15, 1e9, 1.0))
    batch = memory.sample(1000, beta=1.0)
    assert batch.indices.min() == 15
    assert (batch.weights == 1).all()
    no = np.zeros(1, bool)
    memory.add(np.zeros(1, int), np.zeros(1), no, no, observations=np.zeros((1, 2, 2), np.uint8))
    assert 25 in memory.sample(100, beta=1.0).indices


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 39), st.floats(0, 1e3)), max_size=60))
def test_the_last_of_equal_indices_counts(updates: list[tuple[int, float]]) -> None:
    memory = filled(40, exponent=1.0)
    mass = np.ones(40)
    for index, priority in updates:
        mass[index] = priority
    memory.update_priorities(np.array([i for i, _ in updates], int), np.array([p for _, p in updates], float))
    if mass.sum() == 0:
        return
    batch = memory.sample(32, beta=1.0)
    weights = 1 / mass[batch.indices]
    np.testing.assert_allclose(batch.weights, weights / weights.max(), rtol=1e-5)


def test_bad_priorities_change_nothing() -> None:
    memory = filled(10)
    for indices, priorities, error in (
        ([0, 1], [1.0, -1.0], ValueError),
        ([0, 1], [1.0, np.nan], ValueError),
        ([0, 1], [1.0, np.inf], ValueError),
        ([0, 1], [1.0, 1e101], ValueError),
        ([0, 99], [1.0, 1.0], ValueError),
        ([0, -1], [1.0, 1.0], ValueError),
        ([0, 1], [1.0], ValueError),
        ([[0, 1]], [[1.0, 2.0]], ValueError),
        ([0.5], [1.0], TypeError),
        (["a"], [1.0], TypeError),
    ):
        with pytest.raises(error):
            memory.update_priorities(np.array(indices), np.array(priorities))
    memory.update_priorities(np.array([], int), np.array([]))
    assert (memory.sample(10, beta=1.0).weights == 1).all()
    memory.update_priorities(np.arange(10), np.zeros(10))
    with pytest.raises(ValueError, match="are 0"):
        memory.sample(1, beta=1.0)
    with pytest.raises(ValueError, match="priority_exponent"):
        ReplayMemory(10, 1, (2, 2)).update_priorities(np.array([0]), np.array([1.0]))


@pytest.mark.parametrize(("exponent", "most"), [(0.5, 1e100), (1.0, 1e100), (4.0, 9.99e24)])
def test_priorities_are_bounded(exponent: float, most: float) -> None:
    memory = filled(20, exponent=exponent)
    for wrong in (most * 1.01, 1e308, np.nan, np.inf, -1e-9):
        with pytest.raises(ValueError, match=r"priority 1 must be within 0\.\.1e100, and its power by .* too, got "):
            memory.update_priorities(np.arange(2), np.array([1.0, wrong]))
    memory.update_priorities(np.arange(20), np.full(20, most))
    memory.update_priorities(np.array([3]), np.array([1e-300]))
    batch = memory.sample(1000, beta=1.0)
    assert (batch.weights == 1).all()
    assert len(np.unique(batch.indices)) == 19


@pytest.mark.parametrize("beta", [0.5, 30.0])
def test_weights_are_finite(beta: float) -> None:
    memory = filled(10, exponent=1.0)
    memory.update_priorities(np.arange(10), np.full(10, 1e-320))
    assert (memory.sample(64, beta=beta).weights == 1).all()
    memory.update_priorities(np.array([4]), np.array([1e-300]))
    weights = memory.sample(64, beta=beta).weights
    assert np.isfinite(weights).all()
    assert weights.max() == 1


class NaivePriorities:
    """The priorities of steps, and by row the greatest that was given to one of its steps."""

    def __init__(self, rows: int, lanes: int) -> None:
        self.rows, self.lanes, self.row = rows, lanes, 0
        self.priority: dict[int, float] = {}
        self.given: dict[int, float] = {}

    def add(self) -> None:
        new = max(self.given.values(), default=0.0) or 1.0
        self.priority |= dict.fromkeys(range(self.row * self.lanes, (self.row + 1) * self.lanes), new)
        self.row += 1
        oldest = self.row - self.rows
        self.given = {row: priority for row, priority in self.given.items() if row >= oldest}
        self.priority = {i: priority for i, priority in self.priority.items() if i // self.lanes >= oldest}

    def update(self, index: int, priority: float) -> None:
        if index in self.priority:
            row = index // self.lanes
            self.priority[index] = priority
            self.given[row] = max(self.given.get(row, 0.0), priority)


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 3), st.integers(1, 9), st.integers(0, 2**20))
def test_new_steps_get_the_greatest_priority_of_stored_rows(lanes: int, rows: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    memory = ReplayMemory(rows * lanes, lanes, (2, 2), priority_exponent=1.0, seed=0)
    naive = NaivePriorities(rows, lanes)
    frames, no = np.zeros((lanes, 2, 2), np.uint8), np.zeros(lanes, bool)
    memory.reset(frames)
    for _ in range(40):
        memory.add(np.zeros(lanes, int), np.zeros(lanes), no, no, observations=frames)
        naive.add()
        count = int(random.integers(0, 4))
        indices = random.integers(0, naive.row * lanes, count)
        priorities = np.array([random.choice([0.0, 1e-9, 0.5, 1.0, 7.0, 1e100]) for _ in range(count)])
        memory.update_priorities(indices, priorities)
        for index, priority in zip(indices.tolist(), priorities.tolist(), strict=True):
            naive.update(index, priority)
        if random.random() < 0.2:
            memory.restore(memory.state())
        if not any(naive.priority.values()):
            continue
        batch = memory.sample(40, beta=1.0)
        drawn = np.array([naive.priority[int(index)] for index in batch.indices])
        assert (drawn > 0).all()
        np.testing.assert_allclose(batch.weights, drawn.min() / drawn, rtol=1e-6)
