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


SPECS: dict[str, dict[str, Any]] = {
    "defaults": {},
    "RGB": {"gray_scale": False, "stack_num": 2},
    "size": {"img_height": 50, "num_envs": 2},
    "all actions": {"full_action_space": True},
}


@pytest.mark.parametrize("case", SPECS)
def test_same_specs(case: str) -> None:
    import envpool

    theirs, own = (module.make_spec("Breakout-v5", **SPECS[case]) for module in (envpool, ours))
    for name in ("state_array_spec", "action_array_spec"):
        wanted = {key: repr(array) for key, array in getattr(theirs, name).items()}
        got = {key: repr(array) for key, array in getattr(own, name).items()}
        assert list(got) == list(wanted)
        assert {key for key in got if got[key] != wanted[key]} <= {"reward", "info:reward"}  # the least value
    assert own.action_spec() == theirs.action_spec()
    assert own.observation_spec()._fields == theirs.observation_spec()._fields
    for one, other in zip(own.observation_spec(), theirs.observation_spec(), strict=True):
        if getattr(one, "name", "") != "reward":
            assert one == other
    assert set(own.config._fields) == set(theirs.config._fields)
    same = {"base_path", "gym_reset_return_info"}
    differing = {key for key, value in theirs.config._asdict().items() if getattr(own.config, key) != value}
    assert differing <= same


DM: dict[str, dict[str, Any]] = {
    "defaults": {},
    "discount": {"zero_discount_on_life_loss": True},
    "lives": {"zero_discount_on_life_loss": True, "episodic_life": True},
    "limit": {"max_episode_steps": 30},
}


@pytest.mark.parametrize("case", DM)
def test_same_time_steps(case: str) -> None:
    import envpool

    options = {"num_envs": 2, "noop_max": 1, **DM[case]}
    theirs, own = (module.make_dm("Breakout-v5", **options) for module in (envpool, ours))
    assert own.reward_spec() == theirs.reward_spec()
    assert own.discount_spec() == theirs.discount_spec()
    rng = np.random.default_rng(0)
    steps = theirs.reset(), own.reset()
    for _ in range(300):
        for wanted, got in zip(leaves(steps[0]), leaves(steps[1]), strict=True):
            assert (got.dtype, got.shape) == (wanted.dtype, wanted.shape)
            np.testing.assert_array_equal(got, wanted)
        chosen = np.arange(2) if rng.random() < 0.8 else rng.permutation(2)[:1]
        actions = rng.integers(4, size=len(chosen))
        steps = theirs.step(actions, chosen), own.step(actions, chosen)


def leaves(step: Any) -> Iterator[Any]:
    for part in step:
        if isinstance(part, tuple):
            yield from leaves(part)
        else:
            yield part


def test_same_screens() -> None:
    import envpool

    for size in ({}, {"render_width": 80, "render_height": 100}, {"render_width": 400, "render_height": 300}):
        options = {"num_envs": 3, "noop_max": 1, "render_mode": "rgb_array", "render_env_id": 1, **size}
        theirs, own = (module.make("Pong-v5", "gymnasium", **options) for module in (envpool, ours))
        for envs in (theirs, own):
            envs.reset()
            for _ in range(20):
                envs.step(np.array([2, 3, 0]))
        for arguments in ((), ([2, 0],), (1, 3)):
            np.testing.assert_array_equal(own.render(*arguments), theirs.render(*arguments))
