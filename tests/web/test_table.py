"""The table of games for the page: entries of all games, and of a game of your own."""

import gzip
import json
from pathlib import Path

import pytest

import atari
from atari.games.interventions import load
from atari.games.objects import positions
from atari.roms.image import md5
from atari.web.table import FORMAT, core_text, entry, table_files

CATCH = Path(__file__).parent.parent.parent / "examples" / "catch"


@pytest.mark.parametrize("name", atari.games)
def test_an_entry_agrees_with_its_text(name: str) -> None:
    game = atari.games[name]
    one = entry(game)
    assert json.loads(json.dumps(one))["id"] == name
    assert one["md5"] == game.rom.md5
    lines = [line.partition(" ") for line in one["core"].splitlines()]
    assert lines[0] == ("table", " ", str(FORMAT))
    assert [rest.split()[0] for key, _, rest in lines if key == "label"] == [label["name"] for label in one["labels"]]
    assert [label["name"] for label in one["labels"]] == list(game.ram_labels)
    assert sum(key == "object" for key, *_ in lines) == len(one["objects"]) == len(positions(game.ram_labels))
    definitions = [text for one in one["interventions"] for text in one["writes"]]
    assert [rest for key, _, rest in lines if key == "definition"] == definitions
    assert [json.loads(rest)["name"] for key, _, rest in lines if key == "intervention"] == list(load(game))
    two = game.multiplayer is not None and 2 in game.multiplayer.modes
    assert (one["two_players"] is not None) == two


def test_the_files() -> None:
    own = atari.games.resolve(CATCH / "catch.toml")
    written = table_files([atari.games["pong"], own])
    index = json.loads(written["index.json"])
    assert index["format"] == FORMAT
    assert index["games"] == {
        "pong": {"title": "Pong", "md5": atari.games["pong"].rom.md5},
        "catch": {"title": "Catch", "md5": md5((CATCH / "catch.bin").read_bytes())},
    }
    files = [json.loads(written[f"games/{name}.json"]) for name in index["games"]]
    whole = json.loads(gzip.decompress(written["table.json.gz"]))
    assert whole == {**index, "games": files}
    assert files[1]["core"] == core_text(own, (CATCH / "catch.bin").read_bytes())
    assert files[0]["manual"]["modes"].keys() <= {str(mode) for mode in atari.games["pong"].modes}
    assert files[1]["manual"] is None
