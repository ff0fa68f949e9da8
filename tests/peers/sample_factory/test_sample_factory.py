"""Sample Factory's own Atari script trains with one line more, `import atari`, in one process and in several."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest

import atari

pytest.importorskip(
    "sample_factory", reason="Sample Factory requires an old Gymnasium; run ./scripts/test --peer sample_factory"
)
pytestmark = pytest.mark.peers

SCRIPT = """
import sys
import atari
from sf_examples.atari.train_atari import main

if __name__ == "__main__":
    sys.exit(main())
"""
SMALL = {
    "device": "cpu",
    "num_workers": 1,
    "num_envs_per_worker": 2,
    "train_for_env_steps": 2000,
    "rollout": 32,
    "batch_size": 64,
    "num_batches_per_epoch": 1,
    "num_epochs": 1,
}


@pytest.mark.parametrize("serial", [True, False])
def test_its_script_trains(serial: bool, tmp_path: Path) -> None:
    (tmp_path / "train.py").write_text(SCRIPT)
    options = {"env": "atari_breakout", "experiment": "one", "train_dir": "logs", "serial_mode": serial, **SMALL}
    command = [sys.executable, "train.py", *(f"--{name}={value}" for name, value in options.items())]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Collected {0: 2" in done.stdout + done.stderr
    assert list(tmp_path.glob("logs/one/checkpoint_p0/checkpoint_*.pth"))


@pytest.mark.parametrize("name", ["pong", "breakout", "montezuma"])
def test_its_environments_are_what_they_are_around_ale_py(name: str) -> None:
    from sf_examples.atari.atari_utils import atari_env_by_name, make_atari_env

    cfg = SimpleNamespace(env_frameskip=4, env_framestack=4)
    env_id = atari_env_by_name(f"atari_{name}").env_id
    ours = make_atari_env(f"atari_{name}", cfg, None)
    assert isinstance(ours.unwrapped, atari.AtariEnv)
    spec = gymnasium.registry[env_id]
    try:
        gymnasium.registry[env_id] = gymnasium.envs.registration.EnvSpec(
            env_id, "ale_py.env:AtariEnv", max_episode_steps=spec.max_episode_steps, kwargs=spec.kwargs
        )
        theirs = make_atari_env(f"atari_{name}", cfg, None)
    finally:
        gymnasium.registry[env_id] = spec
    assert not isinstance(theirs.unwrapped, atari.AtariEnv)
    ours.action_space.seed(0)
    np.testing.assert_array_equal(ours.reset(seed=3)[0], theirs.reset(seed=3)[0])
    for _ in range(500):
        action = ours.action_space.sample()
        result, expected = ours.step(action), theirs.step(action)
        np.testing.assert_array_equal(result[0], expected[0])
        assert result[1:4] == expected[1:4]
        if result[2] or result[3]:
            np.testing.assert_array_equal(ours.reset()[0], theirs.reset()[0])
