"""The environments of trainings play the bytes of the first release that had them."""

import hashlib
import json
from typing import Any

import numpy as np
import pytest

from atari.learning.environments import TrainingEnvironments
from atari.learning.options import TrainingOptions

LIVES: dict[str, Any] = {"episodic_life": True, "img_height": 42, "img_width": 42, "stack_num": 2}
RAM: dict[str, Any] = {"obs_type": "ram", "stack_num": 3}
CASES: list[tuple[str, str, dict[str, Any], str]] = [
    ("breakout", "dqn2015", {}, "dd2928d9839457c8"),
    ("ms_pacman", "machado2018", {}, "777e2de0ee3d5fa1"),
    ("breakout", "baselines", {}, "489266864da7669e"),
    ("pong", "baselines", {"actions": ("NOOP", "RIGHT", "LEFT")}, "1aeb9b177c4f8dbf"),
    ("breakout", "baselines", RAM, "21011eaf3e38f819"),
    ("ms_pacman", "gymnasium", LIVES, "9073010c0d500b1f"),
    ("breakout", "dopamine", {"stacked": False}, "019f0808df562f01"),
    ("breakout", "atari100k", {}, "df746afcae5a5764"),
    ("breakout", "envpool", LIVES, "c796354b8503bd16"),
    ("pong", "envpool", {"actions": ("FIRE", "RIGHTFIRE", "LEFTFIRE")}, "c6a354c3bebfc58e"),
    ("breakout", "envpool", RAM, "a385c1518c168c2f"),
    ("breakout", "envpool", {"repeat_action_probability": 0.1}, "188cb693133e981e"),
    ("breakout", "ale_vector", {}, "83ebaaa69e377ee4"),
    ("breakout", "ale_vector", {"actions": ("LEFT", "RIGHT", "NOOP"), "episodic_life": True}, "ce014dbb34abdf67"),
]


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
            if options.from_ram:  # the digests have these rows also where environments go on
                others = ~(terminations | truncations)
                final[others, :-1] = before[others, 1:]
            total.update(np.ascontiguousarray(final).tobytes())
    total.update(json.dumps([[score, length] for _, score, length in envs.take_games()]).encode())
    envs.close()
    return total.hexdigest()[:16]


@pytest.mark.parametrize(("game", "preset", "given", "expected"), CASES)
def test_bytes_stay(game: str, preset: str, given: dict[str, Any], expected: str) -> None:
    own = {name: value for name, value in given.items() if name != "stacked"}
    sees = {"stack_num": 4} if "obs_type" in own else {"img_height": 84, "img_width": 84, "stack_num": 4}
    options = TrainingOptions.of(game, **{"preset": preset, "num_envs": 3, **sees, **own})
    assert digest(options, given.get("stacked", True)) == expected


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
