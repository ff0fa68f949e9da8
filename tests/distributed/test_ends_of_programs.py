"""Programs on a cluster of Ray run to their end, and nothing of this package is left then."""

import os
import secrets
import tempfile

import pytest
from own_process import REPORTING, printed_at_end

pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

PROGRAM = """
import ray, atari
from atari.integrations.ray import RolloutActors
ray.init(num_cpus=2, include_dashboard=False, object_store_memory=200_000_000, _temp_dir={folder!r})
actors = RolloutActors("pong", 2, 2, "random", steps=4, preset="dqn2015")
rollout = next(actors)
envs = atari.AtariVectorEnv("pong", 2)
envs.reset(seed=0)
env = ray.get(ray.put(atari.AtariEnv("pong")))
"""


def test_nothing_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program ends that has actors, or environments beside a cluster."""
    with tempfile.TemporaryDirectory(prefix="atari-ray-", dir="/tmp", ignore_cleanup_errors=True) as folder:
        monkeypatch.setenv("HOME", folder)
        monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        monkeypatch.setenv("RAY_AUTH_TOKEN", secrets.token_hex(32))
        monkeypatch.setenv("PYTHONPATH", os.environ.get("PYTHONPATH", ""))
        assert "nanobind" not in printed_at_end(REPORTING + PROGRAM.format(folder=folder))
