"""Each command with each kind of name of a game: its id, an ID of either form, and the file of a game definition."""

from pathlib import Path

import pytest
from cli_tools import Capture, read, read_json, refused

import atari
import atari.roms
from atari.cli import main
from atari.cli.arguments import find_game
from atari.learning.evaluation.played import resolve_games
from atari.learning.options import TrainingOptions
from atari.recording.replay.file_format import is_replay
from atari.task.arguments import read_game

CATCH = str(Path(__file__).parents[2] / "examples" / "catch" / "catch.toml")
ROM = str(atari.roms.find("pong"))
NAMES = {"pong": "pong", "ALE/Pong-v5": "pong", "PongNoFrameskip-v4": "pong", CATCH: "catch", ROM: "pong"}

COMMANDS = {
    "info": ["info", "GAME"],
    "info of a task": ["info", "GAME", "--preset", "dqn2015"],
    "record": ["record", "GAME", "--policy", "random", "--seconds", "0.1", "-o", "game.a26r"],
    "record without a policy": ["record", "GAME", "--steps", "3", "--no-video"],
    "verify": ["verify", "GAME", "--frames", "3", "--core", "plain", "--jobs", "1"],
    "roms verify": ["roms", "verify", "GAME"],
    "evaluate": ["evaluate", "random", "GAME", "--episodes", "1"],
    "causes": ["causes", "GAME", "--states", "1", "--values", "1", "--frames", "1", "--threads", "1"],
}
"""Commands that end by themselves, in little time."""


@pytest.mark.parametrize("name", NAMES, ids=["game", "v5", "v4", "file", "rom"])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_takes_every_kind_of_name(command: str, name: str, capsys: Capture) -> None:
    words = [name if word == "GAME" else word for word in COMMANDS[command]]
    if command == "evaluate" and name == "PongNoFrameskip-v4":  # which has no sticky actions
        words += ["--protocol", "baselines"]
    assert main([*words, "--json"]) == 0, capsys.readouterr().err
    out = capsys.readouterr().out
    assert NAMES[name] in out.lower() or command == "verify"


@pytest.mark.parametrize("name", NAMES, ids=["game", "v5", "v4", "file", "rom"])
def test_the_other_commands_resolve_names_alike(name: str) -> None:
    """`play` and `lab` call `find_game`, and `watch` and `collect` `resolve_games`."""
    assert find_game(name).id == NAMES[name]
    assert resolve_games(read_game(name))[0].id == NAMES[name]


@pytest.mark.parametrize("name", NAMES, ids=["game", "v5", "v4", "file", "rom"])
def test_a_training_resolves_names(name: str) -> None:
    assert TrainingOptions.of(read_game(name)).task.game == NAMES[name]


def test_a_game_of_ones_own_is_explained(capsys: Capture) -> None:
    for words in ([CATCH], [CATCH, "--frameskip", "2"]):
        assert "Catch-v5 and Catch-ram-v5, after atari.register_game(" in read(capsys, "info", *words)
        assert read_json(capsys, "info", *words)["ids"] == ["Catch-v5", "Catch-ram-v5"]


def test_a_file_is_told_by_its_content() -> None:
    """The ending .a26 is the usual one of ROMs; a replay of this name opens all the same."""
    assert main(["record", "pong", "--policy", "noop", "--seconds", "0.1", "-o", "game.a26r"]) == 0
    Path("game.a26r").rename("game.a26")
    Path("Pong (1977).a26").write_bytes(Path(ROM).read_bytes())
    assert is_replay("game.a26")
    assert not is_replay("Pong (1977).a26")
    for words in (["replay", "verify", "game.a26"], ["record", "pong", "--policy", "game.a26", "-o", "game.gif"]):
        assert main(words) == 0
    assert read_game("Pong (1977).a26") == "pong"


def test_a_folder_of_a_games_name_hides_no_game() -> None:
    Path("pong").mkdir()
    assert read_game("pong") == "pong"
    with pytest.raises(ValueError, match="another file or folder"):
        read_game("./pong")


def test_a_file_that_names_no_game(capsys: Capture) -> None:
    Path("mine.a26").write_bytes(bytes(4096))
    refused(capsys, ["info", "mine.a26"], "a game of your own is named by its definition (.toml), with --rom mine.a26")
    Path("game.a26").write_bytes(b"ATARIRPL" + bytes(99))
    text = "game.a26 is another file or folder; name the game, and give a policy or"
    refused(capsys, ["info", "game.a26"], text)
