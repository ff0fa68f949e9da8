"""Grids: their texts, their runs, the words of their commands, their table, and a whole sweep."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("torch")

from cli_tools import Capture, Patch, refused
from small_trainings import kill_after_a_row, sweep_in_this_process

from atari.cli import main
from atari.learning import PROTOCOLS, Result, RunFolder
from atari.learning.agent import agent_code
from atari.learning.agents.ppo import PPO
from atari.learning.evaluation.results import GameResult
from atari.learning.sweep.plan import check_folder, find_grid, plan
from atari.learning.sweep.processes import grid_words
from atari.learning.sweep.report import compare_runs, grid_rows
from atari.learning.training import Training

TINY = (
    "--total-steps 1024 --num-envs 8 --horizon 32 --minibatch 256 --checkpoint-minutes 0 --games 0 --episodes 1 --protocol dopamine "
    "--network small --img-height 42 --img-width 42"
).split()


def resolve(game: str, seed: int, chosen: Any) -> Any:
    return PPO.options_class.of(game, seed=seed, **{"num_envs": 4, "minibatch": 64, "horizon": 16, **chosen})


def test_texts() -> None:
    assert find_grid([]) == {}
    assert find_grid(["learning-rate=1e-4, 3e-4", "gamma=0.99"]) == {
        "learning_rate": ["1e-4", "3e-4"],
        "gamma": ["0.99"],
    }


@pytest.mark.parametrize(
    ("texts", "error"),
    [
        (["gamma"], "as in learning_rate=1e-4,3e-4, got 'gamma'"),
        (["gamma="], "got 'gamma='"),
        (["gamma=0.9,"], "got 'gamma=0.9,'"),
        (["=0.9"], "got '=0.9'"),
        (["seed=0,1"], "the seeds of a sweep are --seeds"),
        (["gamma=0.9", "gamma=0.8"], "names gamma, or one of its values, twice in 'gamma=0.8'"),
        (["gamma=0.9,0.9"], "twice in 'gamma=0.9,0.9'"),
    ],
)
def test_wrong_texts(texts: list[str], error: str) -> None:
    with pytest.raises(ValueError, match=error):
        find_grid(texts)


def test_runs_are_all_combinations_and_are_named_by_their_values(tmp_path: Path) -> None:
    grid = {"learning_rate": [1e-4, 0.0003], "frameskip": [4, (2, 5)]}
    runs = plan(["pong"], [0, 1], tmp_path, resolve, grid)
    assert [run.name for run in runs[:5]] == [
        "pong-learning_rate=0.0001-frameskip=4-seed0",
        "pong-learning_rate=0.0001-frameskip=4-seed1",
        "pong-learning_rate=0.0001-frameskip=2,5-seed0",
        "pong-learning_rate=0.0001-frameskip=2,5-seed1",
        "pong-learning_rate=0.0003-frameskip=4-seed0",
    ]
    assert len(runs) == 8
    assert (runs[2].options.learning_rate, runs[2].options.task.frameskip, runs[2].options.seed) == (1e-4, (2, 5), 0)
    assert runs[2].values == {"learning_rate": "0.0001", "frameskip": "2,5"}


def test_equal_values_in_other_words_are_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ValueError, match=r"the sweep has pong-learning_rate=0\.0001-seed0 twice; leave one of the seeds, or"
    ):
        plan(["pong"], [0], tmp_path, resolve, {"learning_rate": [1e-4, 0.0001]})
    with pytest.raises(ValueError, match="pong is named twice"):
        plan(["pong", "pong"], [0], tmp_path, resolve, {"gamma": [0.9]})


def test_words() -> None:
    chosen = {"learning_rate": 1e-4, "stop_score": None, "episodic_life": True, "pool_rgb": False, "interventions": "x"}
    assert grid_words(chosen) == [
        "--learning-rate=0.0001", "--stop-score=none", "--episodic-life", "--no-pool-rgb", "--intervention=x"
    ]  # fmt: skip


def test_a_grid_with_more_values_extends_a_sweep(tmp_path: Path) -> None:
    (run,) = plan(["pong"], [0], tmp_path, resolve, {"gamma": [0.9]})
    Training.begin("ppo", run.options, run.path).close()
    code = agent_code("ppo")
    check_folder(tmp_path, code, plan(["pong"], [0], tmp_path, resolve, {"gamma": [0.8, 0.9]}), resolve)
    check_folder(tmp_path, code, plan(["pong"], [0], tmp_path, resolve, {"gamma": [0.8]}), resolve)
    with pytest.raises(ValueError, match=r"gamma=0.9-seed0 has gamma=0.9, and this sweep 0.99; give another folder"):
        check_folder(tmp_path, code, plan(["pong"], [0], tmp_path, resolve, {"learning_rate": [0.1]}), resolve)


def test_the_table_has_means_over_seeds_and_marks_the_best_of_each_game() -> None:
    runs = plan(["pong", "breakout"], [0, 1], Path("runs"), resolve, {"gamma": [0.9, 0.99]})
    results = [
        Result(
            "ppo", PROTOCOLS["dopamine"], 0, (GameResult(run.options.task.game, (score,), (9,), (False,), (3,)),), 4000
        )
        for run, score in zip(runs, (1.0, 3.0, 8.0, 8.0, 20.0, 30.0, 5.0, 7.0), strict=True)
    ]
    assert grid_rows(runs, results) == [
        ("game", "gamma", "seeds", "mean score", ""),
        ("pong", "0.9", "2", "2.0 [1.0, 3.0]", ""),
        ("pong", "0.99", "2", "8.0 [8.0, 8.0]", "best"),
        ("breakout", "0.9", "2", "25.0 [20.0, 30.0]", "best"),
        ("breakout", "0.99", "2", "6.0 [5.0, 7.0]", ""),
    ]
    comparison = compare_runs("ppo", runs, results, (), mixed=False)
    assert comparison is not None
    assert [(row.name, row.runs) for row in comparison.rows] == [("gamma=0.9", 2), ("gamma=0.99", 2)]


@pytest.mark.parametrize(
    ("grid", "text", "code"),
    [
        ("learing_rate=1e-4", "unrecognized arguments: --learing-rate=1e-4; did you mean '--learning-rate'?", 2),
        ("gamma=0.9,x", "argument --gamma: gamma must be a number, got 'x'", 2),
        ("gamma=0.9,-1", "gamma must be finite and not negative, got -1.0", 2),
        ("frameskip=4,3", "plays 4 frames an action, the policy 3", 1),
        ("gamma", "as in learning_rate=1e-4,3e-4, got 'gamma'", 1),
    ],
)
def test_wrong_names_and_values_are_refused_before_the_first_run(
    grid: str, text: str, code: int, tmp_path: Path, monkeypatch: Patch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    refused(capsys, ["train", "ppo", "pong", "--grid", grid, *TINY], text, code)
    assert not any(tmp_path.iterdir())


def test_an_option_of_the_grid_is_no_flag_too(tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["train", "ppo", "pong", "--gamma", "0.9", "--grid", "gamma=0.8", *TINY]
    refused(capsys, words, "argument --gamma: it is given twice; leave one of them out", 2)


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_sweep_over_a_grid_that_is_killed_and_goes_on(tmp_path: Path, monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.chdir(tmp_path)
    sweep_in_this_process(monkeypatch)
    words = ["train", "--json", "--grid", "gamma=0.9,0.99", "ppo", "pong", "--grid", "learning-rate=1e-4", "-o", "runs"]
    names = [f"pong-gamma={gamma}-learning_rate=0.0001-seed0" for gamma in (0.9, 0.99)]
    kill_after_a_row([*words, *TINY], Path("runs", names[0], "log.csv"))
    assert not Path("runs", "report.html").exists()
    assert main([*words, *TINY]) == 0
    capsys.readouterr()  # of the trainings, which are in this process
    assert sorted(path.parent.name for path in Path("runs").glob("*/policy.pt")) == names
    assert [RunFolder.open(Path("runs", name)).config["options"]["gamma"] for name in names] == [0.9, 0.99]
    page = Path("runs", "report.html").read_text()
    assert "<h2>By option</h2>" in page
    assert page.count("class=best") in (1, 2)
    assert "--grid gamma=0.9,0.99 --grid learning_rate=1e-4" in page
    assert main([*words, *TINY]) == 0  # all is done: nothing is trained or played
    printed = json.loads(capsys.readouterr().out)
    assert [one["grid"] for one in printed["runs"]] == [
        {"gamma": gamma, "learning_rate": "0.0001"} for gamma in ("0.9", "0.99")
    ]
