"""`atari.integrations.envpool` beside EnvPool: what `reset` and `step` return, for all environments and for some.

The no-ops are one here, because the two draw them from different generators.
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from atari.integrations import envpool as ours

pytestmark = pytest.mark.peers

CASES: dict[str, dict[str, Any]] = {
    "defaults": {},
    "lives": {"episodic_life": True, "reward_clip": True},
    "limit": {"episodic_life": True, "max_episode_steps": 37},
    "every frame": {"frame_skip": 1},
    "two frames": {"frame_skip": 2, "stack_num": 2},
    "one image": {"stack_num": 1, "frame_skip": 3},
    "size": {"img_height": 64, "img_width": 72},
    "RGB": {"gray_scale": False},
    "all actions": {"full_action_space": True},
    "no FIRE": {"use_fire_reset": False, "episodic_life": True},
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("task", ["Breakout-v5", "Pong-v5", "MsPacman-v5", "Seaquest-v5", "SpaceInvaders-v5"])
def test_same_results(task: str, case: str) -> None:
    import envpool

    options = {"num_envs": 3, "noop_max": 1, **CASES[case]}
    theirs, own = envpool.make(task, "gymnasium", **options), ours.make(task, "gymnasium", **options)
    assert own.observation_space == theirs.observation_space
    assert own.action_space == theirs.action_space
    assert set(theirs.config) - set(own.config) <= {"env_seed"}
    rng = np.random.default_rng(0)
    assert_same(theirs.reset(), own.reset())
    for step in range(250):
        chosen = np.arange(3) if rng.random() < 0.8 else rng.permutation(3)[: rng.integers(1, 4)]
        if step % 50 == 49:
            assert_same(theirs.reset(chosen), own.reset(chosen))
        else:
            actions = rng.integers(own.action_space.n, size=len(chosen))
            assert_same(theirs.step(actions, chosen), own.step(actions, chosen))


def test_inside_compiled_functions() -> None:
    script = Path(__file__).parents[1] / "integrations" / "scripts" / "xla_style.py"
    command = [sys.executable, "-m", "atari.integrations.envpool", str(script)]
    environment = {**os.environ, "JAX_PLATFORMS": "cpu"}
    result = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
    assert result.returncode == 0, result.stderr
    assert result.stdout.endswith("[3 2 1 0] int32\n")
    assert "leaked" not in result.stderr


def assert_same(theirs: tuple[Any, ...], own: tuple[Any, ...]) -> None:
    expected, got = dict(flat(theirs)), dict(flat(own))
    assert set(got) == {*expected, f"{len(own) - 1}.TimeLimit.truncated"}
    for name, array in expected.items():
        assert (got[name].dtype, got[name].shape) == (array.dtype, array.shape), name
        np.testing.assert_array_equal(got[name], array, name)


def flat(values: tuple[Any, ...] | dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items() if isinstance(values, dict) else enumerate(values):
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value
