"""`atari train` with several games and seeds: kills, equality with single trainings, results, and wrong input."""

import json
import os
import sys
from contextlib import closing
from pathlib import Path
from threading import Event
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from cli_tools import Capture, Patch  # noqa: E402
from small_trainings import kill_after_a_row, sweep_in_this_process  # noqa: E402

from atari.base.frozen import FrozenDict  # noqa: E402
from atari.cli import main  # noqa: E402
from atari.learning import PROTOCOLS, RunFolder  # noqa: E402
from atari.learning.agent import agent_code  # noqa: E402
from atari.learning.command import training_options  # noqa: E402
from atari.learning.run_log import read_last_row  # noqa: E402
from atari.learning.sweep.plan import plan  # noqa: E402
from atari.learning.sweep.processes import Settings, do_runs, grid_words  # noqa: E402
from atari.learning.training import Training  # noqa: E402

TINY = (
    "--total-steps 1024 --num-envs 8 --horizon 32 --minibatch 256 --checkpoint-minutes 0 "
    "--network small --img-height 42 --img-width 42"
).split()
SWEEP = "--jobs 2 -o runs --games 0 --episodes 1 --protocol dopamine".split()
WORDS = ["train", "ppo", "pong", "--seeds", "0,3", *SWEEP, *TINY]
NAMES = ["pong-seed0", "pong-seed3"]
NO_GRID: Any = FrozenDict()


def resolve(game: str, seed: int, chosen: Any = NO_GRID) -> Any:
    words = [game, *TINY, *grid_words(chosen), "--seed", str(seed)]
    return training_options(agent_code("ppo"), words, "atari train ppo")


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_sweep_that_is_killed_ends_as_one_that_was_not(tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    """The sweep is killed in its trainings, then a process of one of them; the same command goes on."""
    monkeypatch.chdir(tmp_path)
    runs = plan(["pong"], [0, 3], Path("runs"), resolve)
    assert [run.name for run in runs] == NAMES
    kill_after_a_row(WORDS, runs[0].path / "log.csv")
    killed_at = read_last_row(runs[0].path / "log.csv")["step"]

    command = (sys.executable, "-m", "atari.cli.sweep")
    settings = Settings("ppo", tuple(TINY), 0, PROTOCOLS["dopamine"], 1, 2, command)
    killed: list[str] = []

    def kill_one(every: Any) -> None:
        if not killed and every[1].process is not None and every[1].row:
            every[1].process.kill()
            killed.append(every[1].run.name)

    done = do_runs(runs, settings, Event(), kill_one)
    (failed,) = (one for one in done if one.state == "failed")
    assert [failed.run.name] == killed
    assert failed.error == "it was ended by signal 9; the same command goes on"

    sweep_in_this_process(monkeypatch)
    assert main(WORDS) == 0
    shown = capsys.readouterr()
    assert f"{killed[0]} done 1,024 1,024" in shown.err
    assert "human-normalised scores (table noop57), games: 1" in shown.out
    assert "no published agent of protocol dopamine has scores of these games at 4,096 frames" in shown.out
    page = Path("runs", "report.html").read_text()
    assert all(name in page for name in NAMES)
    assert page.count("No game has ended in the training") == 1
    assert Path("runs", "comparison.svg").exists()

    for run in runs:
        with closing(Training.begin("ppo", run.options, Path("alone", run.name))) as training:
            training.run()
        alone, own = (RunFolder.open(path) for path in (training.folder.path, run.path))
        assert [own.config[name] for name in ("options", "task")] == [
            alone.config[name] for name in ("options", "task")
        ]
        weights = own.load_weights()
        assert all(torch.equal(value, weights[name]) for name, value in alone.load_weights().items())
        assert [row["step"] for row in own.rows()] == [row["step"] for row in alone.rows()]
    assert killed_at <= 1024

    before = {file: file.stat().st_mtime_ns for file in Path("runs").glob("*/policy.pt")}
    assert main(["train", "--json", *WORDS[1:]]) == 0  # all is done: nothing is trained or played
    printed = json.loads(capsys.readouterr().out)
    assert {file: file.stat().st_mtime_ns for file in before} == before
    assert [Path(one["run"]).name for one in printed["runs"]] == NAMES
    assert printed["comparison"]["rows"][0]["runs"] == 2
    assert main([*WORDS, "--gamma", "0.9"]) == 1
    assert "runs/pong-seed0 has gamma=0.99, and this sweep 0.9" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["ppo", "pong,pong"], "pong is named twice, as 'pong' and 'pong'; leave one of them out"),
        (["a2c", "pong,breakout"], "there is no agent 'a2c'; there are ppo, pqn, dqn, and Python files of your own"),
        (["ppo", "pong,breakout", "--protocol", "dopamin"], "did you mean 'dopamine'"),
        (["--seeds", "2-0", "ppo", "pong"], "as in 0-2,7, got '2-0'"),
        (["ppo", "pong", "--seeds", "2-0"], "as in 0-2,7, got '2-0'"),
        (["ppo", "pong,breakout", "--seed", "3"], "a sweep has --seeds, such as --seeds 0-2; leave --seed out"),
        (["ppo", "pong", "--seeds", "0", "--protocol", "dopamin"], "did you mean 'dopamine'"),
        (["ppo", "pong", "--seeds", "0", "--frameskip", "3"], "plays 4 frames an action, the policy 3"),
        (["ppo", "pong", "--seeds", "0", "--compare", "dopamine/rainbw"], "dopamine/rainbow"),
        (["ppo", "pong", "--seeds", "0", "--compare", "dopamine/rainbow"], "protocol 'dopamine' has its environ"),
        (
            ["ppo", "pong", "--mode", "1", "--protocol", "dopamine", "--seeds", "0", "--compare", "dopamine/rainbow"],
            "pong is played with another mode than in",
        ),
        (["ppo", "pong", "--seeds", "0", "--compare", "cleanba/cleanba_ppo_8gpu"], "scores only at 200,000,000 frames"),
        (
            ["--resume", "runs/pong", "--seeds", "0"],
            "--seeds, --grid and --jobs are for new trainings; leave them out beside",
        ),
        (
            ["--seeds", "0", "--resume", "runs/pong"],
            "--seeds, --grid and --jobs are for new trainings; leave them out beside",
        ),
        # With the usage
        (["ppo", "pong,breakuot"], "did you mean 'breakout'?"),
        (["ppo", "pong", "--seeds", "0", "--clip", "x"], "argument --clip"),
        (["ppo", "pong", "--seeds", "0", "--colour", "1"], "unrecognized arguments: --colour 1"),
        (["ppo", "--seeds", "0-2"], "the following arguments are required: GAME"),
        (["ppo", "pong", "--seeds", "0", "--jobs", "0"], "argument --jobs"),
        (["ppo", "pong", "--seeds", "0", "--print-task"], "--print-task is for one training; leave it out"),
    ],
)
def test_wrong_input_is_one_sentence(
    words: list[str], text: str, tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    status = main(["train", *words])
    shown = capsys.readouterr().err
    assert status == (2 if shown.startswith("usage: ") else 1)
    assert text in shown
    assert status == 2 or (shown.startswith("atari: error: ") and shown.count("\n") == 1)
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize(
    "words",
    [
        "ppo pong,breakout --fast --actions UP,DOWN --seeds 1-2",
        "--seeds 1-2 --fast --actions UP,DOWN ppo pong,breakout",
        "--fast ppo --seeds=1-2 pong,breakout --actions UP,DOWN",
        "ppo --actions UP,DOWN pong,breakout --fast --jobs 3 --seeds 1,2",
    ],
)
def test_options_stand_before_and_after_the_agent_and_its_games(words: str, tmp_path: Path, monkeypatch: Patch) -> None:
    monkeypatch.chdir(tmp_path)
    seen: list[Any] = []
    monkeypatch.setattr("atari.cli.sweep._do", lambda *given: seen.append(given) or SystemExit())
    monkeypatch.setattr("atari.cli.sweep._finish", lambda *given: 0)
    assert main(["train", *words.split()]) == 0
    (_, code, options, folder, runs), *_ = seen
    assert (code.name, folder) == ("ppo", Path("runs/ppo-sweep"))
    assert sorted(options) == ["--actions", "--fast", "UP,DOWN"]
    assert [run.name for run in runs] == ["pong-seed1", "pong-seed2", "breakout-seed1", "breakout-seed2"]
    assert {run.options.network for run in runs} == {"small"}


@pytest.mark.parametrize("words", ["ppo pong --actions UP,DOWN", "ppo --noops 0,0 pong --fast", "ppo atari.toml"])
def test_a_comma_in_an_option_makes_no_sweep(words: str, monkeypatch: Patch) -> None:
    seen: list[str] = []
    monkeypatch.setattr("atari.cli.train.run_sweep", lambda *given: pytest.fail("a sweep"))
    monkeypatch.setattr("atari.learning.command.train", lambda code, *given: seen.append(code.name))
    assert main(["train", *words.split()]) == 0
    assert seen == ["ppo"]


def test_the_processes_of_an_agent_of_your_own_have_a_copy_of_its_file(tmp_path: Path, monkeypatch: Patch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("atari.learning.programs.user_data_path", lambda *_, **__: tmp_path / "data")
    source = "from atari.learning.agents.ppo import PPO\n\nclass Mine(PPO):\n    pass\n"
    Path("mine.py").write_text(source)
    seen: list[Settings] = []
    monkeypatch.setattr(
        "atari.learning.sweep.processes.do_runs", lambda runs, settings, *_: seen.append(settings) or []
    )
    monkeypatch.setattr("atari.cli.sweep._finish", lambda *given: 0)
    assert main(["train", "mine.py", *WORDS[2:]]) == 0
    copy = Path("runs", "mine.py")
    assert seen[0].agent == f"{copy}:Mine"
    assert copy.read_text() == source


def test_a_folder_has_one_sweep_at_a_time(tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    from atari.base import durable

    monkeypatch.chdir(tmp_path)
    Path("runs").mkdir()
    with durable.lock_file(Path("runs", "sweep.lock"), ""):
        assert main(WORDS) == 1
    assert "a sweep writes into runs; wait for its end, or stop it" in capsys.readouterr().err
