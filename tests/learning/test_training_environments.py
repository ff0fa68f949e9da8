"""The environments of trainings play the bytes of release 0.2, for configurations of format 1."""

import hashlib
import json
from typing import Any

import numpy as np
import pytest

from atari.learning.environments import TrainingEnvironments
from atari.learning.options import TrainingOptions

OPTIONS_OF_FORMAT_1: dict[str, Any] = {
    "game": "pong", "obs": "pixels", "seed": 0, "total_steps": 10_000_000, "stop_score": None, "num_envs": 3,
    "protocol": "baselines", "sticky": None, "episodic_life": None, "actions": None, "image_size": 84, "stack": 4,
    "network": "nature", "normalize": False, "bfloat16": False, "learning_rate": 2.5e-4, "gamma": 0.99, "device": "cpu",
    "workers": 1, "checkpoint_minutes": 5.0,
}  # fmt: skip

CASES: list[tuple[str, dict[str, Any], bool, str]] = [
    ("breakout", {"protocol": "dqn2015"}, True, "dd2928d9839457c8"),
    ("ms_pacman", {"protocol": "machado2018"}, True, "777e2de0ee3d5fa1"),
    ("breakout", {"protocol": "baselines"}, True, "489266864da7669e"),
    ("pong", {"protocol": "baselines", "actions": ("NOOP", "RIGHT", "LEFT")}, True, "1aeb9b177c4f8dbf"),
    ("breakout", {"protocol": "baselines", "obs": "ram", "stack": 3}, True, "21011eaf3e38f819"),
    (
        "ms_pacman",
        {"protocol": "gymnasium", "episodic_life": True, "image_size": 42, "stack": 2},
        True,
        "9073010c0d500b1f",
    ),
    ("breakout", {"protocol": "dopamine"}, False, "019f0808df562f01"),
    ("breakout", {"protocol": "atari100k"}, True, "df746afcae5a5764"),
    (
        "breakout",
        {"protocol": "envpool", "episodic_life": True, "image_size": 42, "stack": 2},
        True,
        "c796354b8503bd16",
    ),
    ("pong", {"protocol": "envpool", "actions": ("FIRE", "RIGHTFIRE", "LEFTFIRE")}, True, "c6a354c3bebfc58e"),
    ("breakout", {"protocol": "envpool", "obs": "ram", "stack": 3}, True, "a385c1518c168c2f"),
    ("breakout", {"protocol": "envpool", "sticky": 0.1}, True, "188cb693133e981e"),
    ("breakout", {"protocol": "ale_vector"}, True, "83ebaaa69e377ee4"),
    (
        "breakout",
        {"protocol": "ale_vector", "actions": ("LEFT", "RIGHT", "NOOP"), "episodic_life": True},
        True,
        "ce014dbb34abdf67",
    ),
]


def now(game: str, protocol: str, **old: Any) -> TrainingOptions:
    """The present options for a configuration of format 1."""
    size, stack = old.pop("image_size", 84), old.pop("stack", 4)
    ram = old.pop("obs", "pixels") == "ram"
    sees: dict[str, Any] = {"obs_type": "ram"} if ram else {"img_height": size, "img_width": size}
    sees["stack_num"] = stack
    renamed = {{"sticky": "repeat_action_probability"}.get(name, name): value for name, value in old.items()}
    return TrainingOptions.of(game, preset=protocol, num_envs=3, **sees, **renamed)


def digest(options: TrainingOptions, stacked: bool, steps: int = 400) -> str:
    """A checksum of everything that a learner gets in some steps."""
    envs = TrainingEnvironments(options, 3, stacked=stacked)
    total, random = hashlib.sha256(), np.random.default_rng(7)
    observations = envs.reset(seed=3)
    total.update(np.ascontiguousarray(observations).tobytes())
    for _ in range(steps):
        before = observations
        chosen = random.integers(len(envs.actions), size=3)
        observations, rewards, terminations, truncations, info = envs.step(chosen)
        for array in (observations, rewards.astype(np.int64), terminations, truncations):
            total.update(np.ascontiguousarray(array).tobytes())
        if (terminations | truncations).any():
            final = info["final_obs"].copy()
            if options.from_ram:  # 0.2 had these rows also where environments go on
                others = ~(terminations | truncations)
                final[others, :-1] = before[others, 1:]
            total.update(np.ascontiguousarray(final).tobytes())
    total.update(json.dumps([[score, length] for _, score, length in envs.take_games()]).encode())
    envs.close()
    return total.hexdigest()[:16]


@pytest.mark.parametrize(("game", "old", "stacked", "expected"), CASES)
def test_bytes_are_those_of_release_0_2(game: str, old: dict[str, Any], stacked: bool, expected: str) -> None:
    assert digest(now(game, **old), stacked) == expected


def test_a_stack_of_ram_goes_on_where_that_of_images_does() -> None:
    options: dict[str, Any] = {"preset": "envpool", "obs_type": "ram", "network": "mlp"}
    for given, clears in (({"episodic_life": True}, True), ({"life_loss_info": True}, False)):
        envs = TrainingEnvironments(TrainingOptions.of("breakout", **options, **given), 1)
        before = envs.reset(seed=0)
        ended = np.zeros(1, np.bool_)
        while not ended.any():
            before, _, terminations, truncations, _ = envs.step(np.array([1]))
            ended = terminations | truncations
        assert (before[0] == before[0, -1]).all() == clears
        envs.close()
