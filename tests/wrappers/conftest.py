"""Fixtures of the tests of wrappers: an environment that follows a script."""

from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces

from atari import AtariEnv

MEANINGS = ["NOOP", "FIRE", "UP", "DOWN"]


class ScriptedEnv(gymnasium.Env):
    """Every observation is filled with the number of frames since the last reset; all else follows a script.

    Frame t gives the reward `rewards.get(t, 0)`, ends the episode if t is `ends` (terminated) or `limit` (truncated),
    and leaves `lives(t)` lives. `actions` and `resets` are what was called.
    """

    def __init__(self, shape=(6, 4), meanings=MEANINGS, rewards=None, ends=None, limit=None, lives=lambda t: 0):
        self.observation_space = spaces.Box(0, 255, shape, np.uint8)
        self.action_space = spaces.Discrete(len(meanings))
        self._meanings = meanings
        self._rewards, self._ends, self._limit, self._lives = rewards or {}, ends, limit, lives
        self.actions: list[Any] = []
        self.resets: list[tuple[int | None, dict | None]] = []

    def get_action_meanings(self):
        return self._meanings

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.resets.append((seed, options))
        self.frame = 0
        return self._observation(), self._info()

    def step(self, action):
        self.actions.append(action)
        self.frame += 1
        t = self.frame
        return self._observation(), self._rewards.get(t, 0.0), t == self._ends, t == self._limit, self._info()

    def _observation(self):
        return np.full(self.observation_space.shape, self.frame % 256, np.uint8)

    def _info(self):
        return {"lives": self._lives(self.frame), "frame": self.frame}


@pytest.fixture
def scripted() -> type[ScriptedEnv]:
    return ScriptedEnv


@pytest.fixture
def game_env() -> Iterator[Callable[..., AtariEnv]]:
    """Makes environments that play one frame a step without sticky actions, and closes them after the test."""
    made: list[AtariEnv] = []

    def make(game: str, **options: Any) -> AtariEnv:
        made.append(AtariEnv(game, **{"frameskip": 1, "repeat_action_probability": 0.0, **options}))
        return made[-1]

    yield make
    for env in made:
        env.close()
