"""`atari info`."""

import pytest
from cli_tools import read, read_json

import atari
from atari.cli import main
from atari.task import env_ids


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
        "RAM           44 names for bytes of it (name:index)",
        "position_x: player_x:72, ball_x:99",
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
    assert facts["ids"] == [env_id for env_id, (_, of) in env_ids.ids().items() if of == game]


def test_info_json_has_rules_and_labels(capsys: pytest.CaptureFixture[str]) -> None:
    facts = read_json(capsys, "info", "breakout")
    assert facts["rules"]["lives_initial"] == 5
    assert ["reward", "points - score"] in facts["rules"]["step"]
    assert facts["ram_labels"]["ball_x"]["index"] == 99
    assert facts["controllers"]["paddle_range"] == [27450, 790196]
    assert facts["screen"]["format"] == "NTSC"


def test_info_of_an_unknown_game_suggests_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "MsPacMen"]) == 1
    assert capsys.readouterr().err == "atari: error: there is no game 'MsPacMen'; did you mean 'ms_pacman'?\n"


def test_info_takes_the_name_of_an_id(capsys: pytest.CaptureFixture[str]) -> None:
    assert read(capsys, "info", "MsPacman") == read(capsys, "info", "ms_pacman")


def test_info_takes_an_id(capsys: pytest.CaptureFixture[str]) -> None:
    assert read(capsys, "info", "Pong-ramDeterministic-v4") == read(capsys, "info", "pong")


def test_info_says_what_the_manual_says(capsys: pytest.CaptureFixture[str]) -> None:
    lines = [line.strip() for line in read(capsys, "info", "freeway").splitlines()]
    assert "released      1981, Activision" in lines
    assert any(line.startswith("about         A chicken crosses ten lanes") for line in lines)
    assert "end           The time is over." in lines
    modes = lines.index("modes         0, 1, 2, 3, 4, 5, 6, 7 (default 0)")
    assert lines[modes + 1] == "0  light traffic of cars"
    difficulties = lines.index("difficulties  0, 1")
    assert lines[difficulties + 2] == "1  left switch at A: a hit chicken is thrown back to the start"


def test_info_names_the_modes_of_two_player_cartridges(capsys: pytest.CaptureFixture[str]) -> None:
    lines = [line.strip() for line in read(capsys, "info", "combat").splitlines()]
    assert "1  tanks, open field" in lines
    assert "10  invisible tanks, open field" in lines


def test_info_json_has_the_manual(capsys: pytest.CaptureFixture[str]) -> None:
    manual = read_json(capsys, "info", "freeway")["manual"]
    assert (manual["title"], manual["year"], manual["maker"]) == ("Freeway", 1981, "Activision")
    assert manual["modes"]["0"] == "light traffic of cars"
    assert manual["sources"]["modes"] == ["general knowledge", "play"]
