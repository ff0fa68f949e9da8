"""`DiscreteEnv`, the base of grid worlds."""

from typing import Any

import numpy as np
import pytest

import atari.classic as gym
from atari.classic.envs.toy_text import discrete

TABLE = {
    0: {0: [(1.0, 0, 0.0, False)], 1: [(0.8, 1, 0.0, False), (0.2, 0, -1.0, False)]},
    1: {0: [(1.0, 0, 0.0, False)], 1: [(1.0, 2, 1.0, True)]},
    2: {0: [(1.0, 2, 0.0, True)], 1: [(1.0, 2, 0.0, True)]},
}


def test_it_follows_its_table() -> None:
    env = discrete.DiscreteEnv(3, 2, TABLE, [0.5, 0.5, 0])
    assert repr((env.observation_space, env.action_space)) == "(Discrete(3), Discrete(2))"
    assert (env.nS, env.nA, env.P[1][1]) == (3, 2, [(1.0, 2, 1.0, True)])
    env.seed(0)
    starts = [env.reset() for _ in range(400)]
    assert set(starts) == {0, 1}
    assert 160 < sum(starts) < 240  # four standard deviations
    moved = []
    for _ in range(400):
        env.reset()
        env.s = 0
        state, reward, done, info = env.step(1)
        assert (reward, done, info) == ((0.0, False, {"prob": 0.8}) if state else (-1.0, False, {"prob": 0.2}))
        moved.append(state)
    assert 288 < sum(moved) < 352
    env.s = 1
    assert env.step(1) == (2, 1.0, True, {"prob": 1.0})
    assert env.lastaction == 1


def test_a_seed_repeats() -> None:
    env = discrete.DiscreteEnv(3, 2, TABLE, [0.5, 0.5, 0])
    first, second = ([env.seed(5), *(env.reset() for _ in range(20))] for _ in range(2))
    assert first == second


def test_frozen_lake_is_drawn_as_its_table_says() -> None:
    """The same seed and table give the same walk as Gymnasium's environment, which was a `DiscreteEnv` in Gym."""
    lake = gym.make("FrozenLake-v1")
    isd = np.zeros(16)
    isd[0] = 1
    env = discrete.DiscreteEnv(16, 4, lake.P, isd)  # type: ignore[attr-defined]
    lake.seed(3)
    env.seed(3)
    for _ in range(10):
        assert lake.reset() == env.reset()
        done = False
        while not done:
            observation, reward, done, info = lake.step(2)
            expected = env.step(2)
            assert (observation, reward, done) == expected[:3]
            assert info["prob"] == pytest.approx(expected[3]["prob"])


def test_methods_of_2016() -> None:
    class Line(discrete.DiscreteEnv):
        def _render(self, mode: str = "human", close: bool = False) -> Any:
            return f"{self.s} of {self.nS}"

        def _reset(self) -> int:
            return 10 + super()._reset()

    env = Line(3, 2, TABLE, [0.0, 1.0, 0.0])
    assert (env.reset(), env.step(1), env.render()) == (11, (2, 1.0, True, {"prob": 1.0}), "2 of 3")
