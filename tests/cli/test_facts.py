"""`atari list`, `atari info`, `atari explain`."""

import json
from typing import Any

import pytest

import atari
from atari import registration
from atari.cli import main


def read(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(words) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    return captured.out


def read_json(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    return json.loads(read(capsys, *words, "--json"))


def test_list_has_a_line_for_each_game(capsys: pytest.CaptureFixture[str]) -> None:
    header, *lines = read(capsys, "list").splitlines()
    assert header.split() == ["game", "title", "actions", "modes", "difficulties"]
    assert [line.split()[0] for line in lines] == list(atari.games)
    assert next(line for line in lines if line.startswith("breakout")).split() == [
        "breakout",
        "Breakout",
        "4",
        "12",
        "2",
    ]
    assert "Combat (2 players, no environment)" in next(line for line in lines if line.startswith("combat"))


def test_list_json(capsys: pytest.CaptureFixture[str]) -> None:
    listed = read_json(capsys, "list")
    assert [game["id"] for game in listed] == list(atari.games)
    assert listed[list(atari.games).index("breakout")] == {
        "id": "breakout",
        "title": "Breakout",
        "single_player": True,
        "actions": 4,
        "modes": 12,
        "difficulties": 2,
    }
    assert sum(not game["single_player"] for game in listed) == 4


def test_list_ids_has_every_id_once(capsys: pytest.CaptureFixture[str]) -> None:
    lines = read(capsys, "list", "--ids").splitlines()
    assert lines == list(registration.ids())
    assert len(set(lines)) == len(lines) == 952
    assert read_json(capsys, "list", "--ids") == lines


def test_info_says_what_the_game_file_says(capsys: pytest.CaptureFixture[str]) -> None:
    lines = [line.strip() for line in read(capsys, "info", "breakout").splitlines()]
    assert lines[0] == "breakout: Breakout"
    for expected in (
        "players       1",
        "screen        160 columns, 210 rows, NTSC",
        "controllers   paddles left, joystick right",
        "actions       4 of 18: NOOP FIRE RIGHT LEFT",
        "starts with   no action",
        "modes         0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44 (default 0)",
        "difficulties  0, 1",
        "rules         at reset: lives = 5, score = 0, started = 0",
        "reward = points - score",
        "lives = 0 if terminal else lives_left",
        "terminal = started and lives_left == 0",
        "RAM           44 names for bytes of it",
        "ROM           2048 bytes, 2K, MD5 f34f08e5eb96e500e851a80be3277a56",
        "IDs           Breakout-v0",
        "ALE/Breakout-ram-v5",
    ):
        assert expected in lines


def test_info_of_a_two_player_cartridge(capsys: pytest.CaptureFixture[str]) -> None:
    out = read(capsys, "info", "combat")
    assert "controllers   joystick, both ports" in out
    assert "rules         none for a single player, so there is no environment" in out
    assert "IDs" not in out


@pytest.mark.parametrize("game", list(atari.games))
def test_info_works_for_every_game(game: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert read(capsys, "info", game).startswith(f"{game}: {atari.games[game].title}\n")
    facts = read_json(capsys, "info", game)
    assert facts["id"] == game
    assert facts["rom"]["md5"] == atari.games[game].rom.md5
    assert facts["minimal_actions"] == [action.name for action in atari.games[game].minimal_actions]
    assert facts["ids"] == [env_id for env_id, (_, of) in registration.ids().items() if of == game]


def test_info_json_has_rules_and_labels(capsys: pytest.CaptureFixture[str]) -> None:
    facts = read_json(capsys, "info", "breakout")
    assert facts["rules"]["lives_initial"] == 5
    assert ["reward", "points - score"] in facts["rules"]["step"]
    assert facts["ram_labels"]["ball_x"]["index"] == 99
    assert facts["controllers"]["paddle_range"] == [27450, 790196]
    assert facts["screen"]["format"] == "NTSC"


def test_info_of_an_unknown_game_suggests_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "MsPacMan"]) == 1
    assert capsys.readouterr().err == "atari: error: there is no game 'MsPacMan'; did you mean 'ms_pacman'?\n"


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
