"""Each command with each kind of name of a game: its id, an ID of either form, and the file of a game definition."""

from pathlib import Path

import pytest
from cli_tools import read_json

from atari.cli import main
from atari.cli.arguments import find_game
from atari.learning.evaluation.played import find_entries
from atari.learning.options import TrainingOptions
from atari.task.arguments import game_of

CATCH = str(Path(__file__).parents[2] / "examples" / "catch" / "catch.toml")
NAMES = {"pong": "pong", "ALE/Pong-v5": "pong", "PongNoFrameskip-v4": "pong", CATCH: "catch"}

COMMANDS = {
    "info": ["info", "GAME"],
    "explain": ["explain", "GAME"],
    "demo": ["demo", "GAME", "--steps", "3", "--no-video"],
    "record": ["record", "GAME", "--seconds", "0.1", "-o", "game.a26"],
    "verify": ["verify", "GAME", "--frames", "3", "--core", "plain", "--jobs", "1"],
    "roms verify": ["roms", "verify", "GAME"],
    "evaluate": ["evaluate", "random", "GAME", "--episodes", "1"],
    "causes": ["causes", "GAME", "--states", "1", "--values", "1", "--frames", "1", "--threads", "1"],
}
"""Commands that end by themselves, in little time."""


@pytest.mark.parametrize("name", NAMES, ids=["game", "v5", "v4", "file"])
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_takes_every_kind_of_name(
    command: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = [name if word == "GAME" else word for word in COMMANDS[command]]
    if command == "evaluate" and name == "PongNoFrameskip-v4":  # which has no sticky actions
        words += ["--protocol", "baselines"]
    assert main([*words, "--json"]) == 0, capsys.readouterr().err
    out = capsys.readouterr().out
    assert NAMES[name] in out.lower() or command == "verify"


@pytest.mark.parametrize("name", NAMES, ids=["game", "v5", "v4", "file"])
def test_the_other_commands_resolve_names_alike(name: str) -> None:
    """`play` and `lab` call `find_game`, and `watch` and `collect` `find_entries`."""
    assert find_game(name).id == NAMES[name]
    assert find_entries(game_of(name))[0].id == NAMES[name]


@pytest.mark.parametrize("name", NAMES, ids=["game", "v5", "v4", "file"])
def test_a_training_resolves_names(name: str) -> None:
    assert TrainingOptions.of(game_of(name)).task.game == NAMES[name]


def test_a_game_of_ones_own_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", CATCH]) == 0
    assert "Catch-v5 and Catch-ram-v5, after atari.register_game(" in capsys.readouterr().out
    assert read_json(capsys, "explain", CATCH)["ids"] == ["Catch-v5", "Catch-ram-v5"]
