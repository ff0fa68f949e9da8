"""`atari explain`."""

import json
from pathlib import Path

import pytest
from cli_tools import read, read_json

from atari.cli import main
from atari.registry import registration
from atari.task import Task


def test_explain_prints_the_explanation(capsys: pytest.CaptureFixture[str]) -> None:
    out = read(capsys, "explain", "PongDeterministic-v4")
    assert out == registration.explain("PongDeterministic-v4") + "\n"
    assert "frame skip    4 frames a step" in out


def test_explain_json(capsys: pytest.CaptureFixture[str]) -> None:
    facts = read_json(capsys, "explain", "Pong-ram-v4")
    assert facts["id"] == "Pong-ram-v4"
    assert facts["observation"] == {"shape": [128], "dtype": "uint8"}
    assert facts["options"] == {
        "game": "pong",
        "obs_type": "ram",
        "frameskip": [2, 5],
        "repeat_action_probability": 0.0,
        "full_action_space": False,
        "max_num_frames_per_episode": 108000,
    }
    assert len(facts["siblings"]) == 13
    assert facts["siblings"]["ALE/Pong-v5"]["repeat_action_probability"] == 0.25
    assert "Pong-ram-v4" not in facts["siblings"]


def test_explain_json_of_pixels(capsys: pytest.CaptureFixture[str]) -> None:
    assert read_json(capsys, "explain", "ALE/AirRaid-v5")["observation"]["shape"] == [250, 160, 3]


def test_explain_takes_a_game_a_task_and_flags(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = Task.of("Pong-ram-v4", frameskip=3)
    assert read(capsys, "explain", "Pong-ram-v4", "--frameskip", "3") == f"{task}\n"
    assert read(capsys, "explain", "pong", "--preset", "dqn2015") == f"{Task.of('pong', preset='dqn2015')}\n"
    printed = read(capsys, "explain", "Pong-ram-v4", "--frameskip", "3", "--print-task", "--json")
    (tmp_path / "task.json").write_text(printed)
    assert read(capsys, "explain", str(tmp_path / "task.json")) == f"{task}\n"
    facts = read_json(capsys, "explain", str(tmp_path / "task.json"), "--obs-type", "grayscale", "--stack-num", "4")
    assert facts["observation"] == {"shape": [4, 210, 160], "dtype": "uint8"}
    assert Task.from_json(json.dumps(facts["task"])) == task.replace(obs_type="grayscale", stack_num=4)


@pytest.mark.parametrize("option", [[], ["--json"]])
@pytest.mark.parametrize(("wrong", "right"), [("Breakout-v5", "'ALE/Breakout-v5'"), ("pong-v4", "'Pong-v4'")])
def test_explain_of_a_wrong_id_names_the_right_one(
    wrong: str, right: str, option: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["explain", wrong, *option]) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"atari: error: there is no environment '{wrong}'; did you mean")
    assert right in captured.err
    assert captured.err.count("\n") == 1
