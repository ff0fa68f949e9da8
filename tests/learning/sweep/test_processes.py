"""The processes of a sweep, with a program in place of `atari` that takes no time, and the table that shows them."""

import io
import json
import sys
import time
from pathlib import Path
from threading import Event
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from atari.learning import PROTOCOLS  # noqa: E402
from atari.learning.agents.ppo import PPO  # noqa: E402
from atari.learning.run_folder import RunFolder  # noqa: E402
from atari.learning.sweep.plan import TrainingRun, plan  # noqa: E402
from atari.learning.sweep.processes import Progress, Settings, do_runs, next_step  # noqa: E402
from atari.learning.sweep.table import Table  # noqa: E402

PROGRAM = """
import os, sys, threading, time
with open("calls.txt", "a") as file:
    file.write(" ".join(sys.argv[1:]) + "\\n")
with open("alive.txt", "a") as file:
    file.write(f"+{time.monotonic()}\\n")
mode = open("mode.txt").read()
if mode == "error":
    sys.exit("atari: error: the disk is full")
if mode == "wait":
    os.read(0, 1)  # until the sweep ends
    open("ended.txt", "w").close()
time.sleep(0.3)
with open("alive.txt", "a") as file:
    file.write(f"-{time.monotonic()}\\n")
"""


@pytest.fixture
def settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Settings:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "runs").mkdir()
    command = (sys.executable, str(tmp_path / "program.py"))
    return Settings("ppo", ("--gamma", "0.9"), 0, PROTOCOLS["dopamine"], 3, 2, command)


def runs_of(games: list[str]) -> list[TrainingRun]:
    return plan(games, [0], Path("runs"), lambda game, seed, chosen: PPO.options_class.of(game, seed=seed, gamma=0.9))


def test_the_steps_of_a_run(settings: Settings) -> None:
    (run,) = runs_of(["pong"])
    words = "train --games 0 ppo pong --gamma 0.9 --seed 0 -o runs/pong-seed0".split()
    assert next_step(run, settings) == ("training", tuple(words))
    with RunFolder.begin(run.path, "ppo", run.options.task, {"gamma": 0.9}) as folder:
        assert next_step(run, settings) == ("training", ("train", "--games", "0", "--resume", "runs/pong-seed0"))
        folder.end("steps")
    how = "--protocol dopamine --episodes 3 -o runs/pong-seed0/evaluation-dopamine.json"
    expected = ("evaluating", ("evaluate", "runs/pong-seed0", *how.split()))
    assert next_step(run, settings) == expected
    (run.path / "evaluation-dopamine.json").write_text("{}")
    assert next_step(run, settings) == expected  # it is damaged


@pytest.mark.parametrize(("mode", "reason"), [("", "ended without a result"), ("error", "the disk is full")])
def test_no_more_processes_than_jobs_and_a_failure_does_not_stop_the_others(
    settings: Settings, mode: str, reason: str
) -> None:
    Path("mode.txt").write_text(mode)
    runs = runs_of(["pong", "breakout", "freeway", "qbert"])
    seen: list[int] = []

    def show(every: Any) -> None:
        seen.append(sum(one.process is not None for one in every))

    done = do_runs(runs, settings, Event(), show)
    assert [one.state for one in done] == ["failed"] * 4
    assert all(reason in one.error for one in done)
    assert len(Path("calls.txt").read_text().splitlines()) == 4
    assert max(seen) == 2


def test_the_processes_end_with_the_sweep(settings: Settings) -> None:
    Path("mode.txt").write_text("wait")
    stop, begin = Event(), time.monotonic()

    def show(every: Any) -> None:
        if Path("alive.txt").exists():
            stop.set()
        assert time.monotonic() < begin + 60

    (one,) = do_runs(runs_of(["pong"]), settings, stop, show)
    assert Path("ended.txt").exists()
    assert one.state == "training"


def test_a_run_that_another_process_writes_waits(settings: Settings) -> None:
    Path("mode.txt").write_text("")
    (run,) = runs_of(["pong"])
    folder, states = RunFolder.begin(run.path, "ppo", run.options.task, {}), []

    def show(every: Any) -> None:
        states.append(every[0].state)
        if len(states) == 2:
            folder.close()

    do_runs([run], settings, Event(), show)
    assert states[:3] == ["in use", "in use", "training"]


def test_no_output_goes_through_a_link(settings: Settings, tmp_path: Path) -> None:
    (tmp_path / "other.txt").write_text("other")
    Path("runs", "pong-seed0.log").symlink_to(tmp_path / "other.txt")
    with pytest.raises(OSError, match=r"pong-seed0\.log"):
        do_runs(runs_of(["pong"]), settings, Event(), lambda every: None)
    assert (tmp_path / "other.txt").read_text() == "other"


def test_a_damaged_run_folder_fails(settings: Settings) -> None:
    (run,) = runs_of(["pong"])
    run.path.mkdir()
    (run.path / "config.json").write_text(json.dumps({"format": 99}))
    (one,) = do_runs([run], settings, Event(), lambda every: None)
    assert one.state == "failed"
    assert "format 99" in one.error


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def progress(games: list[str], states: list[str]) -> list[Progress]:
    return [Progress(run, state) for run, state in zip(runs_of(games), states, strict=True)]


@pytest.mark.usefixtures("settings")
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


@pytest.mark.usefixtures("settings")
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
    wide = Terminal()
    Table(wide, 62, 9).show(runs)
    assert wide.getvalue().splitlines()[1] == "pong-seed0      done: long long long long long long long …"
