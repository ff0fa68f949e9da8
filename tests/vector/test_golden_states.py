"""States of cores and lanes keep their bytes: digests of states that an earlier state of the code has saved.

A change of the layout raises `STATE_VERSION`, and these digests are made anew.
"""

import hashlib
from typing import Any

import numpy as np
import pytest

import atari
from atari.cores import NativeCore

CORES = {
    "breakout": "229a8ff172f2bc12",
    "pitfall2": "96b7ec330663be1f",
}
LANES: dict[str, list[str]] = {
    "dqn2015": ["6c414e2914f97b37", "e7c4d0fbe239757f"],
    "machado2018": ["f9198382a5a15cc8", "b917775e42effb78"],
    "baselines": ["1cb1db91fa122775", "d14f2527ca7aee0f"],
    "gymnasium": ["3312e5f3c508a0b3", "fa7cf4549c68e7a6"],
    "dopamine": ["ccf1ade85d550699", "a6cfb52e756bbeca"],
    "atari100k": ["ea3d9f42076f52c3", "7dc82802aae3d4a2"],
    "envpool": ["d6455b972356ceb3", "d7fe53e43ecbbcb9"],
    "ale_vector": ["2a89406f45922763", "4efb498d95614c45"],
    "ale-py": ["628fd4b4f9bcd981", "292e6754bb9ee883"],
    "sticky, drawn skips": ["492cf5650f55edcb", "29e756f195e512fe"],
    "ram stack": ["442e132e9e28cc73", "b10a5093221644d2"],
    "reward": ["8bfb75ff94432c7e", "02c4ce92e883ce92"],
    "seamless": ["5dad401e6c2cd02d", "d58e1e5115b99584"],
}
PLAYERS = ["f7700bf5f54bcc1e", "ea4687270dea5c23"]
OPTIONS: dict[str, dict[str, Any]] = {
    "ale-py": {},
    "sticky, drawn skips": {"repeat_action_probability": 0.25, "frameskip": (2, 5)},
    "ram stack": {"preset": "dqn2015", "obs_type": "ram", "stack_num": 3},
    "reward": {"preset": "baselines", "reward": "reward - 5 * lives_lost"},
    "seamless": {"preset": "envpool", "episodic_life": True},
}
"""The options of the lanes whose name is no preset."""


def digest(state: bytes) -> str:
    return hashlib.sha256(state).hexdigest()[:16]


def digests(envs: atari.AtariVectorEnv, actions: Any) -> list[str]:
    """The digest of each lane's state after 60 steps."""
    envs.reset(seed=3)
    numbers = np.random.default_rng(0)
    for _ in range(60):
        envs.step(numbers.integers(0, *actions))
    return [digest(lane.state.__getstate__()[0]) for lane in envs.snapshot()]  # type: ignore[attr-defined]


@pytest.mark.parametrize("game", CORES)
def test_cores(game: str) -> None:
    core = NativeCore(game, seed=1, repeat_action_probability=0.25)
    core.reset()
    for frame in range(200):
        core.act(frame % 5)
    assert digest(core.save()) == CORES[game]


@pytest.mark.parametrize("name", LANES)
def test_lanes(name: str) -> None:
    options = OPTIONS.get(name, {"preset": name})
    assert digests(atari.AtariVectorEnv("breakout", 2, num_threads=1, **options), (4, 2)) == LANES[name]


def test_lanes_of_two_players() -> None:
    envs = atari.AtariVectorEnv("pong", 2, players=2, preset="multiplayer_dqn", num_threads=1)
    assert digests(envs, (6, (2, 2))) == PLAYERS
