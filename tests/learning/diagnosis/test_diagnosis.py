"""The diagnosis as a whole: what it says, that it is the same every time, its page, its command, and its refusals."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_tools import Capture, read, refused

from atari.cli import main
from atari.learning import diagnose
from atari.learning.diagnosis.diagnosis import Diagnosis
from atari.learning.diagnosis.findings import RESTARTS, is_new
from atari.learning.diagnosis.page import write_diagnosis
from atari.learning.diagnosis.training_log import Standstill, standstill
from atari.learning.frontier import read_frontier
from atari.recording import Replay


def found(**given: Any) -> Diagnosis:
    return diagnose("random", "breakout", **{"games": 3, "frontiers": 2, "seconds": 0.3, **given})


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    return found()


def test_the_same_arguments_give_the_same_diagnosis(diagnosis: Diagnosis) -> None:
    assert str(found()) == str(diagnosis)
    assert str(found(seed=1)) != str(diagnosis)


def test_the_text_has_all_parts(diagnosis: Diagnosis) -> None:
    head, *rest = str(diagnosis).splitlines()
    assert head.startswith("random in Breakout: ")
    assert head.endswith(" in 3 games by baselines")
    titles = [line for line in rest if line and not line.startswith(" ")]
    assert titles == ["Where games end", "Continuations", "What the agent does", *["To try"] * bool(diagnosis.options)]
    assert "  3 of 3 games end with the last life" in str(diagnosis)


def test_the_folder(diagnosis: Diagnosis, tmp_path: Path) -> None:
    page = write_diagnosis(diagnosis, tmp_path / "new" / "folder")
    text = page.read_text()
    names = {path.name for path in page.parent.iterdir()}
    assert {"index.html", "diagnosis.txt", "frontier.states", "lost-0.a26r", "lost-0.mp4", "lost-1.a26r"} <= names
    assert all(f'src="{name}"' in text for name in names if name.endswith(".mp4"))
    assert all(Replay.load(page.parent / name).verify() for name in names if name.endswith(".a26r"))
    frontier = read_frontier(page.parent / "frontier.states", diagnosis.plays.task)
    assert max(frontier.scores) <= diagnosis.plays.scores.max()
    assert (page.parent / "diagnosis.txt").read_text() == f"{diagnosis}\n"


def test_nothing_of_an_earlier_diagnosis_stays(diagnosis: Diagnosis, tmp_path: Path) -> None:
    (tmp_path / "lost-keys.txt").touch()
    write_diagnosis(diagnosis, tmp_path)
    write_diagnosis(found(games=1, frontiers=0), tmp_path)
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"index.html", "diagnosis.txt", "frontier.states", "lost-keys.txt"}


def test_one_game_has_no_error() -> None:
    assert re.match(r"random in Breakout: \d+\.0 in 1 game by baselines\n", str(found(games=1, frontiers=0)))


def test_a_log_of_other_columns_is_refused_before_the_games(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    run = shutil.copytree(Path(__file__).parents[3] / "examples" / "breakout-pqn", tmp_path / "run")
    (run / "log.csv").write_text("step,loss\n1,2\n")
    with pytest.raises(ValueError, match=r"log.csv is damaged: it has no column frames"):
        diagnose(run, progress=lambda *_: pytest.fail("a game was played"))


def test_the_command(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = ("diagnose", "random", "breakout", "--episodes", "2", "--frontiers", "0")
    text = read(capsys, *words)
    assert text.rstrip().endswith("diagnosis/breakout/index.html")
    facts = json.loads(read(capsys, *words, "--json"))
    assert facts["text"] in text
    assert len(facts["scores"]) == 2


def test_the_command_prints_probes(capsys: Capture) -> None:
    pytest.importorskip("sklearn", reason="scikit-learn is not installed")
    run = str(Path(__file__).parents[3] / "examples" / "breakout-pqn")
    _, head, *lines, left_out = read(capsys, "diagnose", run, "--probes", "4000").splitlines()
    assert re.split("  +", head)[2:] == ["R2 trained", "R2 random", "R2 pixels", "F1 trained", "F1 random", "F1 pixels"]
    (ball,) = (line for line in lines if line.startswith("ball_x"))
    trained, random, *_ = map(float, ball.split()[2:])
    assert trained > random + 0.1
    assert left_out.startswith("left out, because their bytes hardly change: ")
    found = json.loads(read(capsys, "diagnose", run, "--probes", "4000", "--json"))
    assert found["trained"]["r2"]["ball_x"] == pytest.approx(trained, abs=1e-3)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["random", "pong", "--probes"], "policy random has no features; these have: run folders of PPO"),
        (["random", "pong", "--probes", "--seconds", "1"], "leave --seconds out"),
        (["random"], "does not say which game it plays"),
        (["random", "atari26"], "a diagnosis is of one game, got 26"),
        (["nothing.zip", "pong"], "nothing.zip"),
        (["random", "pong", "--protocol", "dopamin"], "did you mean 'dopamine'"),
    ],
)
def test_refusals(words: list[str], text: str, capsys: Capture, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    refused(capsys, ["diagnose", *words], text)
    assert not any(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_is_refused_before_the_games(capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert main(["diagnose", "random", "pong", "-o", str(tmp_path / "file" / "diagnosis")]) == 1
    assert "file" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "value"), [("games", 0), ("frontiers", -1), ("seconds", 0), ("seed", -1)])
def test_arguments_out_of_range(name: str, value: int) -> None:
    with pytest.raises(ValueError, match=name):
        found(**{name: value})


def rows(scores: Any, **columns: Any) -> list[dict[str, float]]:
    return [
        {
            "step": index * 1e4,
            "frames": index * 4e4,
            "score": score,
            **{name: column[index] for name, column in columns.items()},
        }
        for index, score in enumerate(scores)
    ]


def test_a_standstill_is_where_the_score_stops_to_rise() -> None:
    scores = np.minimum(np.arange(200), 100)
    at = standstill(rows(scores, epsilon=np.linspace(1, 0, 200)), {"anneal": True, "total_steps": 2e6})
    assert at is not None
    assert 95 * 4e4 <= at.frames <= 103 * 4e4
    assert at.epsilon == pytest.approx(0.5, abs=0.02)
    assert at.rate == pytest.approx(0.51, abs=0.02)


@pytest.mark.parametrize(
    "scores", [np.arange(200), np.full(5, 3.0), np.full(200, np.nan), np.r_[np.arange(100), np.zeros(100)]]
)
def test_no_standstill(scores: Any) -> None:
    assert standstill(rows(scores), {}) is None


@pytest.mark.parametrize(
    ("epsilon", "rate", "lanes", "options"),
    [
        (0.01, 0.3, False, ("--lane-epsilon 0.4", "--anneal-from 0.8")),
        (0.01, 0.9, True, ()),
        (0.5, None, False, ()),
        (None, 0.1, False, ("--anneal-from 0.8",)),
    ],
)
def test_options_of_a_standstill(epsilon: Any, rate: Any, lanes: bool, options: Any) -> None:
    assert Standstill(10.0, 1e6, 2e6, epsilon, rate, lanes).options == options


def test_a_training_had_the_defaults_of_options_that_its_configuration_lacks() -> None:
    pytest.importorskip("torch")
    run = Path(__file__).parents[3] / "examples" / "qbert-pqn"
    assert "restart_share" not in json.loads((run / "config.json").read_text())["options"]
    found = diagnose(run, games=1, frontiers=0)
    assert found.options == ("--lane-epsilon 0.4", "--anneal-from 0.8")
    assert is_new(RESTARTS, found.training)


@pytest.mark.parametrize(
    ("option", "training", "new"),
    [
        ("--sticky 0.25", {"repeat_action_probability": 0.25}, False),
        ("--sticky 0.25", {"repeat_action_probability": 0.0}, True),
        ("--stack-num 4", {"stack_num": 2}, True),
        ("--epsilon 0.01", {"epsilon": 0.001, "lane_epsilon": None}, True),
        ("--epsilon 0.01", {"epsilon": 0.001, "lane_epsilon": 0.4}, False),
        ("--epsilon 0.01", {"gamma": 0.99}, False),
        ("--epsilon 0.001", {"epsilon": 0.01}, True),
        ("--action-delay 0", {"action_delay": 3}, True),
        ("--exploration 0.2", {"exploration": 100_000}, False),
        ("--network nature", {"network": "nature"}, False),
        ("--img-height 84 --img-width 84", {"img_height": 84, "img_width": 42}, True),
        (RESTARTS, {"restart_share": 0.25, "restart_from": None}, True),
        (RESTARTS, {}, False),
    ],
)
def test_only_options_that_the_training_did_without_are_to_try(option: str, training: Any, new: bool) -> None:
    assert is_new(option, training) == new
