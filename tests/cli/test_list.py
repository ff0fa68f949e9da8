"""`atari list`."""

import pytest
from cli_tools import read, read_json

import atari
from atari.task import env_ids


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
    assert "Combat (2 players: see --players)" in next(line for line in lines if line.startswith("combat"))


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
    assert lines == list(env_ids.ids())
    assert len(set(lines)) == len(lines) == 952
    assert read_json(capsys, "list", "--ids") == lines


def test_environments_of_several_players(capsys: pytest.CaptureFixture[str]) -> None:
    lines = read(capsys, "list", "--players", "4").splitlines()
    assert [line.split()[0] for line in lines[1:]][-2:] == ["volleyball_pong_v3", "warlords_v3"]
    names = [row["environment"] for row in read_json(capsys, "list", "--players", "2")]
    assert len(names) == 31
    assert names[-9:] == [
        "atlantis", "backgammon", "blackjack", "bowling", "fishing_derby", "freeway", "hangman", "human_cannonball",
        "tic_tac_toe_3d",
    ]  # fmt: skip
