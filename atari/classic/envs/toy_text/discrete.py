"""`DiscreteEnv`: an environment defined by a table of transitions, the base of grid worlds in courses."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from atari.classic.core import Env, Step
from atari.classic.spaces import Discrete
from atari.classic.utils import seeding

Transition = tuple[float, int, float, bool]
"""Probability, next state, reward, done."""


class DiscreteEnv(Env):
    """An environment with finitely many states and actions.

    Args:
        nS: number of states.
        nA: number of actions.
        P: the transitions; `P[state][action]` lists the possible ones.
        isd: the probability of each state at the start.
    """

    def __init__(
        self,
        nS: int,
        nA: int,
        P: Mapping[int, Mapping[int, Sequence[Transition]]],
        isd: "npt.ArrayLike",
    ) -> None:
        self.nS, self.nA, self.P, self.isd = nS, nA, P, np.asarray(isd)
        self.lastaction: int | None = None
        self.action_space = Discrete(nA)
        self.observation_space = Discrete(nS)
        self.seed()
        self.s = categorical_sample(self.isd, self.np_random)

    def seed(self, seed: int | None = None) -> list[int]:
        """Seed the transitions and return the seed."""
        self.np_random, seed = seeding.np_random(seed)
        return [seed]

    def reset(self) -> int:
        """Start in a state drawn from `isd`."""
        self.s = categorical_sample(self.isd, self.np_random)
        self.lastaction = None
        return self.s

    def step(self, action: Any) -> Step:
        """Draw one of the transitions; `info["prob"]` is its probability."""
        transitions = self.P[self.s][action]
        drawn = categorical_sample([transition[0] for transition in transitions], self.np_random)
        probability, self.s, reward, done = transitions[drawn]
        self.lastaction = action
        return self.s, reward, bool(done), {"prob": probability}

    _seed, _reset, _step = seed, reset, step  # their names before 2018


def categorical_sample(prob_n: "npt.ArrayLike", np_random: np.random.RandomState) -> int:
    """Draw an index with the given probabilities."""
    return int((np.cumsum(prob_n) > np_random.rand()).argmax())
