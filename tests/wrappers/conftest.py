"""Fixtures of the tests of wrappers: an environment that follows a script, and a contract for every wrapper."""

import copy
import pickle
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import data_equivalence
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

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


def rollout(env: gymnasium.Env, actions: list[Any]) -> list[Any]:
    """All results of these actions, with a reset after each episode."""
    results = []
    for action in actions:
        observation, reward, terminated, truncated, info = env.step(action)
        results.append((np.array(_arrays(observation)), reward, terminated, truncated, timeless(info)))
        if terminated or truncated:
            observation, info = env.reset()
            results.append((np.array(_arrays(observation)), timeless(info)))
    return results


def timeless(info: dict[str, Any]) -> dict[str, Any]:
    """The info without the seconds that a game took."""
    episode = {name: value for name, value in info.get("episode", {}).items() if name != "t"}
    return {**info, "episode": episode}


def _arrays(observation: Any) -> Any:
    if not isinstance(observation, dict):
        return observation
    return np.concatenate([np.ravel(part) for part in observation.values()])


@pytest.fixture
def contract() -> Callable[..., None]:
    """The contract of every wrapped environment."""

    def check(make: Callable[[], gymnasium.Env]) -> None:
        env, twin = make(), make()
        rng = np.random.default_rng(0)
        actions = [int(rng.integers(env.action_space.n)) for _ in range(60)]

        assert env.reset(seed=3)[0] in env.observation_space
        first = rollout(env, actions)

        twin.reset(seed=3)
        assert data_equivalence(first, rollout(twin, actions)), "a seed must reproduce an episode"
        env.reset(seed=3)
        assert data_equivalence(first, rollout(env, actions)), "a seed must start everything over"

        env.reset(seed=4)
        observations, copies = [], []
        for action in actions[:40]:
            observation, reward, terminated, truncated, _ = env.step(action)
            assert observation in env.observation_space
            assert type(reward) is float
            assert type(terminated) is bool
            assert type(truncated) is bool
            observations.append(observation)
            copies.append(copy.deepcopy(observation))
            if terminated or truncated:
                env.reset()
        for kept, copied in zip(observations, copies, strict=True):
            assert data_equivalence(_arrays(kept), _arrays(copied)), "a later step changed an observation"

        for again in (pickle.loads(pickle.dumps(env)), copy.deepcopy(env)):
            position = pickle.loads(pickle.dumps(env))
            assert data_equivalence(rollout(again, actions[:20]), rollout(position, actions[:20]))

        saved = env.snapshot()
        expected = rollout(env, actions)
        for restored in (env, twin):
            restored.restore(saved)
            assert restored.snapshot() == saved
            assert data_equivalence(expected, rollout(restored, actions)), "a snapshot must continue"

        remade = gymnasium.make(env.spec)
        assert str(remade) == str(env)
        remade.reset(seed=3)
        assert data_equivalence(first, rollout(remade, actions)), "env.spec must describe the wrappers"

        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", message=".*different from the unwrapped version")
            warnings.filterwarnings("ignore", message=".*env.seed to get variables")  # the check of Gymnasium 0.29
            check_env(env, skip_render_check=True)
        for each in (env, twin, remade):
            each.close()

    return check
