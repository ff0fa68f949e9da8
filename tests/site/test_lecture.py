"""`scripts/generate/lecture.py`, with trainings that are given: its table, its picture, and when it fails."""

import runpy
import sys
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).parents[2] / "scripts" / "generate" / "lecture.py"


def run(monkeypatch: pytest.MonkeyPatch, output: Path, *last: int) -> None:
    """Run the script with a training for each seed: the scores of its games rise by 1, to the last one."""
    script = runpy.run_path(str(SCRIPT))

    def train(seed: int) -> dict[str, Any]:
        scores = [[1000 * game, last[seed] - 29 + game] for game in range(30)]
        return {"seconds": 100.4 + seed, "scores": scores, "after": [2.0, 3.0]}

    main = script["main"]
    monkeypatch.setitem(main.__globals__, "train", train)
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), "--seeds", *map(str, range(len(last))), "-o", str(output)])
    main()


def test_the_table_and_the_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("matplotlib")
    run(monkeypatch, tmp_path / "a.svg", 0, 20, 10)
    assert capsys.readouterr().out.splitlines() == [
        "| seed | seconds of one core | last 20 games in training | 20 games by dqn2015 |",
        "|---|---|---|---|",
        "| 0 | 100 | -9.5 | 2.5 |",
        "| 1 | 101 | 10.5 | 2.5 |",
        "| 2 | 102 | 0.5 | 2.5 |",
    ]
    run(monkeypatch, tmp_path / "b.svg", 0, 20, 10)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert b"<svg" in (tmp_path / "a.svg").read_bytes()


def test_it_fails_if_the_agents_have_not_learned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib")
    with pytest.raises(SystemExit, match=r"the median score is -0\.5, and above 0 is expected"):
        run(monkeypatch, tmp_path / "a.svg", 21, 9, 0)
