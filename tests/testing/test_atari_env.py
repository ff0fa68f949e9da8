"""`AtariEnv` in all its kinds, and what `atari.make` and IDs make, keep the contract of `atari.testing.check_env`."""

import warnings
from typing import Any

import gymnasium
import pytest

import atari
from atari.testing import check_env

KINDS: dict[str, dict[str, Any]] = {
    "rgb": {},
    "grayscale": {"obs_type": "grayscale", "frameskip": (2, 5)},
    "ram with sound": {"obs_type": "ram", "sound_obs": True},
    "truncated": {"obs_type": "ram", "max_num_frames_per_episode": 90},
    "another mode": {"obs_type": "ram", "mode": 4, "difficulty": 1, "repeat_action_probability": 0.0},
    "reference core": {"obs_type": "ram", "core": "plain"},
    "ale-py": {"obs_type": "ram", "core": "ale"},
}


@pytest.mark.parametrize("kind", KINDS)
def test_kinds_of_environments(kind: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(lambda: atari.AtariEnv("breakout", **KINDS[kind]))


def test_continuous_actions() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*symmetric and normalized space")
        check_env(lambda: atari.AtariEnv("pong", continuous=True))


@pytest.mark.parametrize("env_id", ["ALE/Pong-v5", "Pong-ramNoFrameskip-v4", "Copy-v0", "RepeatCopy-v0"])
def test_ids(env_id: str) -> None:
    check_env(lambda: gymnasium.make(env_id))
    check_env(lambda: atari.make(env_id))
