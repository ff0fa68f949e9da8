"""`examples/go_explore_ray.py`: runs, and its replay has the archive's score."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from atari.recording import Replay

pytest.importorskip("ray", reason="Ray requires a Gymnasium of its own; run ./scripts/test --ray")
pytestmark = pytest.mark.ray

EXAMPLE = Path(__file__).parents[2] / "examples" / "go_explore_ray.py"


def test_the_best_trajectory_can_be_played_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    words = ["--minutes", "0.05", "--workers", "2", "-o", str(tmp_path / "best.a26r")]
    done = subprocess.run([sys.executable, EXAMPLE, *words], capture_output=True, text=True, timeout=120)
    assert not done.returncode, done.stderr
    *lines, last = done.stdout.splitlines()
    assert json.loads(lines[-1])["cells"] > 10
    found = re.search(r"(\d+) steps, score (\d+); the archive has (\d+)", last)
    assert found
    assert found[2] == found[3]
    replay = Replay.load(tmp_path / "best.a26r")
    assert replay.verify()
    assert replay.frames_total == 4 * int(found[1])
