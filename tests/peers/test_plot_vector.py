"""`scripts/bench/plot_vector.py` draws the results of `scripts/bench.py --suite sizes` with matplotlib."""

import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.peers

SCRIPTS = Path(__file__).parents[2] / "scripts"


def test_a_plot_of_all_contestants(tmp_path: Path) -> None:
    measured, plot = tmp_path / "sizes.json", tmp_path / "plot.svg"
    bench = [sys.executable, str(SCRIPTS / "bench.py"), "--suite", "sizes", "--envs", "1", "2", "--steps", "20"]
    subprocess.run([*bench, "--rounds", "1", "--games", "pong", "--json", str(measured)], check=True)
    draw = [sys.executable, str(SCRIPTS / "bench" / "plot_vector.py"), str(measured), str(plot)]
    subprocess.run(draw, check=True)
    text = plot.read_text()
    for label in ("native", "native RAM", "EnvPool", "ale-py", "steps a second"):
        assert f"<!-- {label} -->" in text
    subprocess.run(draw, check=True)
    assert plot.read_text() == text
