"""`atari info`: the list of games, the facts of a game, and what an ID, a task or options play."""

import json
from pathlib import Path

import pytest
from cli_tools import Capture, read, read_json, refused

import atari
from atari.registry import registration
from atari.task import Task, env_ids


def test_info_says_what_the_game_file_says(capsys: Capture) -> None:
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


def test_info_of_a_two_player_cartridge(capsys: Capture) -> None:
    out = read(capsys, "info", "combat")
    assert "controllers   joystick, both ports" in out
    assert "rules         none for a single player, so there is no environment" in out
    assert "IDs" not in out
    assert {"1  tanks, open field", "10  invisible tanks, open field"} <= {line.strip() for line in out.splitlines()}


@pytest.mark.parametrize("game", list(atari.games))
def test_info_works_for_every_game(game: str, capsys: Capture) -> None:
    assert read(capsys, "info", game).startswith(f"{game}: {atari.games[game].title}\n")
    facts = read_json(capsys, "info", game)
    assert facts["id"] == game
    assert facts["rom"]["md5"] == atari.games[game].rom.md5
    assert facts["minimal_actions"] == [action.name for action in atari.games[game].minimal_actions]
    assert facts["ids"] == [env_id for env_id, (_, of) in env_ids.ids().items() if of == game]


def test_info_takes_the_name_of_an_id(capsys: Capture) -> None:
    assert read(capsys, "info", "MsPacman") == read(capsys, "info", "ms_pacman")


def test_info_says_what_the_manual_says(capsys: Capture) -> None:
    lines = [line.strip() for line in read(capsys, "info", "freeway").splitlines()]
    assert "released      1981, Activision" in lines
    assert any(line.startswith("about         A chicken crosses ten lanes") for line in lines)
    assert "end           The time is over." in lines
    modes = lines.index("modes         0, 1, 2, 3, 4, 5, 6, 7 (default 0)")
    assert lines[modes + 1] == "0  light traffic of cars"
    difficulties = lines.index("difficulties  0, 1")
    assert lines[difficulties + 2] == "1  left switch at A: a hit chicken is thrown back to the start"


def test_info_says_what_each_intervention_changes(capsys: Capture) -> None:
    lines = [line.strip() for line in read(capsys, "info", "pong").splitlines()]
    first = lines.index("changes       6 interventions, such as `atari play pong --intervention falling_ball`")
    assert lines[first + 1] == "falling_ball   The ball sinks by one row on every third frame."
    assert read_json(capsys, "info", "pong")["interventions"]["lazy_enemy"] == "The opponent's paddle stands still."
    assert "changes" not in read(capsys, "info", "tetris")
    assert read_json(capsys, "info", "tetris")["interventions"] == {}


def test_info_json_has_rules_labels_and_the_manual(capsys: Capture) -> None:
    facts = read_json(capsys, "info", "breakout")
    assert facts["rules"]["lives_initial"] == 5
    assert ["reward", "points - score"] in facts["rules"]["step"]
    assert facts["ram_labels"]["ball_x"]["index"] == 99
    assert facts["controllers"]["paddle_range"] == [27450, 790196]
    assert facts["screen"]["format"] == "NTSC"
    manual = read_json(capsys, "info", "freeway")["manual"]
    assert (manual["title"], manual["year"], manual["maker"]) == ("Freeway", 1981, "Activision")
    assert manual["modes"]["0"] == "light traffic of cars"
    assert manual["sources"]["modes"] == ["general knowledge", "play"]


def test_list_has_a_line_for_each_game(capsys: Capture) -> None:
    header, *lines = read(capsys, "info", "--games").splitlines()
    assert header.split() == ["game", "title", "actions", "modes", "difficulties"]
    assert [line.split()[0] for line in lines] == list(atari.games)
    assert "breakout Breakout 4 12 2".split() in [line.split() for line in lines]
    assert "Combat (2 players: see --players)" in next(line for line in lines if line.startswith("combat"))


def test_list_json(capsys: Capture) -> None:
    listed = read_json(capsys, "info", "--games")
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


def test_list_ids_has_every_id_once(capsys: Capture) -> None:
    lines = read(capsys, "info", "--ids").splitlines()
    assert lines == list(env_ids.ids())
    assert len(set(lines)) == len(lines) == 952
    assert read_json(capsys, "info", "--ids") == lines


def test_environments_of_several_players(capsys: Capture) -> None:
    lines = read(capsys, "info", "--players", "4").splitlines()
    assert [line.split()[0] for line in lines[1:]][-2:] == ["volleyball_pong_v3", "warlords_v3"]
    assert read(capsys, "info", "--games", "--players", "4").splitlines() == lines
    names = [row["environment"] for row in read_json(capsys, "info", "--players", "2")]
    assert len(names) == 31
    assert names[-9:] == [
        "atlantis", "backgammon", "blackjack", "bowling", "fishing_derby", "freeway", "hangman", "human_cannonball",
        "tic_tac_toe_3d",
    ]  # fmt: skip


def test_explain_prints_the_explanation(capsys: Capture) -> None:
    out = read(capsys, "info", "PongDeterministic-v4")
    assert out == registration.explain("PongDeterministic-v4") + "\n"
    assert "frame skip    4 frames a step" in out


def test_explain_json(capsys: Capture) -> None:
    facts = read_json(capsys, "info", "Pong-ram-v4")
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


def test_explain_takes_a_game_a_task_and_flags(tmp_path: Path, capsys: Capture) -> None:
    task = Task.of("Pong-ram-v4", frameskip=3)
    assert read(capsys, "info", "Pong-ram-v4", "--frameskip", "3") == f"{task}\n"
    assert read(capsys, "info", "pong", "--preset", "dqn2015") == f"{Task.of('pong', preset='dqn2015')}\n"
    printed = read(capsys, "info", "Pong-ram-v4", "--frameskip", "3", "--print-task", "--json")
    (tmp_path / "task.json").write_text(printed)
    assert read(capsys, "info", str(tmp_path / "task.json")) == f"{task}\n"
    facts = read_json(capsys, "info", str(tmp_path / "task.json"), "--obs-type", "grayscale", "--stack-num", "4")
    assert facts["observation"] == {"shape": [4, 210, 160], "dtype": "uint8"}
    assert Task.from_json(json.dumps(facts["task"])) == task.replace(obs_type="grayscale", stack_num=4)


@pytest.mark.parametrize("option", [[], ["--json"]])
@pytest.mark.parametrize(("wrong", "right"), [("Breakout-v5", "'ALE/Breakout-v5'"), ("pong-v4", "'Pong-v4'")])
def test_explain_of_a_wrong_id_names_the_right_one(wrong: str, right: str, option: list[str], capsys: Capture) -> None:
    text = f"there is no environment '{wrong}'; did you mean {right}"
    assert not refused(capsys, ["info", wrong, *option], text)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["breakout", "--ids"], "--ids lists all IDs; leave GAME, --games and the options of a task out"),
        (["--games", "--ids"], "--ids lists all IDs; leave GAME, --games and the options of a task out"),
        (["breakout", "--games"], "--games lists all games; leave breakout out"),
        (["--ids", "--players", "2"], "--ids lists all IDs"),
        (["--games", "--mode", "4"], "options of a task need GAME, got mode"),
        (["--frameskip", "3"], "atari: error: options of a task need GAME, got frameskip without it; name the game"),
        (["--print-task"], "options of a task need GAME, got print_task"),
        (["--players", "2", "--mode", "3"], "options of a task need GAME, got mode"),
        (["--players", "3"], "without GAME, --players lists the games of 2 or 4 players, got 3"),
        (["MsPacMen"], "atari: error: there is no game 'MsPacMen'; did you mean 'ms_pacman'?"),
        (["a.mp4", "--mode", "4"], "a video says what was played; leave the options of a task out"),
    ],
)
def test_words_that_do_not_go_together(words: list[str], text: str, capsys: Capture) -> None:
    assert not refused(capsys, ["info", *words], text)


@pytest.mark.parametrize(
    ("words", "shape"),
    [
        ("ALE/AirRaid-v5", [250, 160, 3]),
        ("Pong-ram-v4 --stack-num 4", [4, 128]),
        ("Pong-ram-v4 --obs-type dict", None),
        ("Pong-ram-v4 --obs-type rgb --sound-obs", None),
    ],
)
def test_the_shape_of_observations(words: str, shape: list[int] | None, capsys: Capture) -> None:
    assert read_json(capsys, "info", *words.split())["observation"]["shape"] == shape


def test_a_game_alone_shows_facts_and_its_task_on_demand(capsys: Capture) -> None:
    assert read(capsys, "info", "pong").startswith("pong: Pong\n  released")
    assert read(capsys, "info", "pong", "--print-task") == f"{Task.of('pong')}\n"
    assert read(capsys, "info", "pong_v3") == f"{Task.of('pong_v3')}\n"
