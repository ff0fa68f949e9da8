"""`scripts/bench/plot_vector.py` reads its curves from `bench.py`'s file. The drawing is tested in the peers' lane."""

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).parent.parent / "scripts" / "bench" / "plot_vector.py"

DOCUMENT: dict[str, Any] = {
    "suite": "sizes",
    "machine": {"processor": "A CPU", "cores": 2},
    "versions": {"atari-envs": "1", "ale-py": "2", "numpy": "3"},
    "results": {
        "pong": {"8 x 84x84 gray": {"native": [10.0, 20.0, 90.0]}, "1 x 84x84 gray": {"native": [50.0]}},
        "breakout": {"8 x 84x84 gray": {"native": [5.0]}, "1 x 84x84 gray": {"native": [50.0]}},
    },
}


@pytest.fixture
def script() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT))


def test_speeds_are_of_medians_and_means_of_games(script: dict[str, Any]) -> None:
    curves = script["curves"](DOCUMENT)
    assert list(curves) == ["native"]
    assert [count for count, _ in curves["native"]] == [1, 8]
    assert [speed for _, speed in curves["native"]] == pytest.approx([20_000, 100_000])
    assert script["subtitle"](DOCUMENT) == "pong, breakout; A CPU, 2 threads\natari-envs 1, ale-py 2"


def test_another_suite_is_refused(
    script: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "raw.json").write_text(json.dumps({"suite": "raw"}))
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), str(tmp_path / "raw.json"), str(tmp_path / "plot.svg")])
    with pytest.raises(SystemExit) as ended:
        script["main"]()
    assert ended.value.code == 2
    assert "is of suite 'raw'; run bench.py --suite sizes --json FILE" in capsys.readouterr().err
    assert not (tmp_path / "plot.svg").exists()
