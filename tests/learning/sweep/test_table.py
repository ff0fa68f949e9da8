"""The table of a sweep while it runs, in a terminal and elsewhere."""

import io
from pathlib import Path

import pytest

torch = pytest.importorskip("torch")

from atari.learning.agents.ppo import PPO  # noqa: E402
from atari.learning.sweep.plan import TrainingRun, plan  # noqa: E402
from atari.learning.sweep.processes import Progress  # noqa: E402
from atari.learning.sweep.table import Table  # noqa: E402


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()


def runs_of(games: list[str]) -> list[TrainingRun]:
    return plan(games, [0], Path("runs"), lambda game, seed: PPO.options_class.of(game, seed=seed))


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def progress(games: list[str], states: list[str]) -> list[Progress]:
    return [Progress(run, state) for run, state in zip(runs_of(games), states, strict=True)]


def test_a_line_a_change_without_a_terminal() -> None:
    stream = io.StringIO()
    table = Table(stream, 80, 24)
    one, other = progress(["pong", "breakout"], ["training", "waiting"])
    table.show([one, other])
    table.show([one, other])
    assert stream.getvalue() == "pong-seed0 training 0 10,000,000 -\n"
    one.run.path.mkdir()
    (one.run.path / "log.csv").write_text("step,score\n128,nan\n256,-20.5\n3")
    one.state, other.state, other.error = "done", "failed", "no\x1b[2J room"
    table.show([one, other])
    assert stream.getvalue().splitlines()[1:] == [
        "pong-seed0 done 256 10,000,000 -20.5",
        "breakout-seed0 failed: no\\x1b[2J room 0 10,000,000 -",
    ]


def test_a_table_in_a_terminal_changes_in_place() -> None:
    stream = Terminal()
    table = Table(stream, 60, 24)
    runs = progress(["pong", "breakout"], ["done", "training"])
    table.show(runs)
    lines = stream.getvalue().splitlines()
    assert [line.split()[:2] for line in lines[:3]] == [
        ["run", "state"],
        ["pong-seed0", "done"],
        ["breakout-seed0", "training"],
    ]
    assert lines[3] == "2 runs: 1 done, 1 training"
    runs[1].state = "evaluating"
    table.show(runs)
    assert "\x1b[4F\x1b[J" in stream.getvalue()
    small = Terminal()
    runs[0].error = "long " * 40
    Table(small, 40, 4).show(runs)  # there is room for one run, the one at work
    assert [line.split()[0] for line in small.getvalue().splitlines()] == ["run", "breakout-seed0", "2"]
    assert max(map(len, small.getvalue().splitlines())) < 40
