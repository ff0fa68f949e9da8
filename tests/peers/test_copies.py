"""The classes for Stable-Baselines3 can be copied, and what records a file refuses."""

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from copied import WAYS, never, plain

pytestmark = pytest.mark.peers


def playing() -> Any:
    from atari.sb3 import AtariVecEnv

    envs = AtariVecEnv("breakout", 2, preset="baselines")
    envs.seed(3)
    envs.reset()
    for action in range(20):
        envs.step(np.full(2, action % 4))
    return envs


def steps(envs: Any) -> list[Any]:
    rng = np.random.default_rng(0)
    results = []
    for _ in range(60):
        observations, rewards, dones, infos = envs.step(rng.integers(4, size=2))
        whole = [{name: value for name, value in info.items() if name != "episode"} for info in infos]
        results.append(plain([observations, rewards, dones, whole]))
    return results


@pytest.mark.parametrize("way", WAYS)
def test_a_copy_of_an_atari_vec_env_plays_on_equally(way: str) -> None:
    envs = playing()
    other = WAYS[way](envs)
    assert steps(other) == steps(envs)
    assert np.array_equal(other.reset(), envs.reset())


def test_recorders(tmp_path: Path) -> None:
    from atari.sb3 import RecordReplay, RecordVideo

    filmed = RecordVideo(playing(), tmp_path / "videos", step_trigger=never)
    other = pickle.loads(pickle.dumps(filmed))
    assert steps(other) == steps(filmed)
    recorded = RecordReplay(playing(), tmp_path / "a.a26r")
    for duplicate in (copy.deepcopy, pickle.dumps):
        with pytest.raises(TypeError, match="RecordReplay writes a file and cannot be copied or pickled"):
            duplicate(recorded)
    recorded.close()
