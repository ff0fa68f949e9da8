"""The manuals: each game has one, its numbers are the game's, and a wrong file raises with the place of the fault."""

import copy
import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, fields, replace
from pathlib import Path
from typing import Any

import pytest

import atari
from atari.games.game import load_game, numbers
from atari.games.manual import SOURCES, Manual, load_manual, parse_manual

FOLDER = Path(atari.__file__).parent / "games" / "manuals"
NUMBERS = {"modes": (0, 4), "difficulties": (0, 1), "multiplayer_modes": (2,)}
TABLE: dict[str, Any] = {
    "title": "Catch",
    "year": 1982,
    "description": "The player\ncatches things.",
    "modes": {"4": "fast", "0": "slow"},
    "notes": ["None."],
    "sources": {key: ["play"] for key in ("title", "year", "description", "modes")},
}


@pytest.mark.parametrize("game_id", list(atari.games))
def test_every_game_has_a_manual(game_id: str) -> None:
    game = atari.games[game_id]
    manual = game.manual
    assert manual is not None
    assert manual.title
    assert 60 < len(manual.description) < 600
    assert manual.year is None or 1977 <= manual.year <= 1992
    own = numbers(game)
    for name in ("modes", "difficulties", "multiplayer_modes"):
        assert set(getattr(manual, name)) <= set(own[name])
    texts = (*manual.modes.values(), *manual.difficulties.values(), *manual.multiplayer_modes.values(), *manual.notes)
    assert not [text for text in texts if "not known" in text or "unknown" in text]
    assert {source for sources in manual.sources.values() for source in sources} <= set(SOURCES)


def test_most_modes_have_a_meaning() -> None:
    """The numbers only rise: raise them with each meaning that becomes known."""
    assert sorted(path.stem for path in FOLDER.glob("*.toml")) == list(atari.games)
    several = [game for game in atari.games.values() if len(game.modes) > 1]
    assert sum(len(game.modes) for game in several) == 520
    assert sum(len(game.manual.modes) for game in several if game.manual) == 431
    shared = [game.manual.multiplayer_modes for game in atari.games.values() if game.manual]
    assert sum(map(len, shared)) == 261
    manual = atari.games["breakout"].manual
    assert manual is not None
    assert list(manual.modes) == [0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 44]
    assert "invisible" in manual.modes[12]
    assert manual.sources["title"] == ("general knowledge",)


def test_a_manual_is_read_once_and_cannot_change() -> None:
    manual = atari.games["pong"].manual
    assert manual is atari.games["pong"].manual
    with pytest.raises(FrozenInstanceError):
        manual.title = "Tennis"  # type: ignore[misc, union-attr]
    assert pickle.loads(pickle.dumps(manual)) == manual == copy.deepcopy(manual)
    assert hash(manual) == hash(copy.deepcopy(manual))


def test_a_game_of_ones_own_has_none(tmp_path: Path) -> None:
    pong = Path(atari.__file__).parent / "games" / "data" / "pong.toml"
    assert load_game(pong).manual is atari.games["pong"].manual
    own = atari.games["pong"]
    assert replace(own, rom=replace(own.rom, md5="0" * 32)).manual is None
    assert replace(own, id="own_pong").manual is None


def test_importing_the_package_reads_no_manual() -> None:
    program = (
        "import os, sys; read = []\n"
        "sys.addaudithook(lambda name, args: read.append(str(args[0])) if name == 'open' else None)\n"
        "import atari; atari.games['pong']\n"
        "print([file for file in read if os.sep + os.path.join('games', 'manuals') in file])\n"
        "atari.games['pong'].manual\n"
        "print(len([file for file in read if file.endswith('manuals' + os.sep + 'pong.toml')]))"
    )
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert result.stdout == "[]\n1\n"


def test_a_table_is_a_manual() -> None:
    manual = parse_manual(TABLE, NUMBERS)
    assert manual.description == "The player catches things."
    assert list(manual.modes.items()) == [(0, "slow"), (4, "fast")]
    assert (manual.maker, manual.reward, dict(manual.difficulties)) == (None, None, {})


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"titel": "x"}, "the file has no key 'titel'"),
        ({"title": None}, "the file needs the key 'title'"),
        ({"title": 3}, "the file: 'title' must be a text, got 3"),
        ({"title": " "}, "title is empty"),
        ({"description": ["x"]}, "the file: 'description' must be a text"),
        ({"year": "1982"}, "the file: 'year' must be a whole number, got '1982'"),
        ({"year": True}, "the file: 'year' must be a whole number, got True"),
        ({"notes": "x"}, "the file: 'notes' must be a list of texts, got 'x'"),
        ({"modes": {"1": "x"}}, r"\[modes\] 1 is not a number that the game has \(0, 4\)"),
        ({"modes": {"04": "x"}}, r"\[modes\] 04 is not a number that the game has"),
        ({"modes": {"-0": "x"}}, r"\[modes\] -0 is not a number"),
        ({"modes": {"9" * 5000: "x"}}, r"\[modes\] 9+ is not a number"),
        ({"modes": {"4": 4}}, r"\[modes\] 4 must be a text, got 4"),
        ({"modes": {"4": ""}}, r"\[modes\] 4 is empty"),
        ({"modes": ["x"]}, "the file: 'modes' must be a table, got"),
        ({"difficulties": {"2": "x"}}, r"\[difficulties\] 2 is not a number that the game has \(0, 1\)"),
        ({"multiplayer_modes": {"3": "x"}}, r"\[multiplayer_modes\] 3 is not a number that the game has \(2\)"),
        ({"sources": {}}, r"\[sources\] needs the key 'title'"),
        ({"sources": "play"}, "the file: 'sources' must be a table, got 'play'"),
        ({"sources": TABLE["sources"] | {"maker": ["play"]}}, r"\[sources\] has no key 'maker'"),
        ({"sources": TABLE["sources"] | {"title": "play"}}, r"\[sources\]: 'title' must be a list of texts, got 'pla"),
        ({"sources": TABLE["sources"] | {"title": ["rumour"]}}, r"\[sources\] title: 'rumour' is not one of 'manual'"),
        ({"sources": TABLE["sources"] | {"title": []}}, r"\[sources\] title is empty"),
    ],
)
def test_a_wrong_table_raises_with_the_place(change: dict[str, Any], message: str) -> None:
    table = {key: value for key, value in {**TABLE, **change}.items() if value is not None}
    with pytest.raises(ValueError, match=message):
        parse_manual(table, NUMBERS)


@pytest.mark.parametrize("text", ["title =", "title = 'x'", "a." * 2000 + "b = 1", "a = " + "[" * 50000])
def test_a_wrong_file_raises_with_its_name(text: str, tmp_path: Path) -> None:
    file = tmp_path / "catch.toml"
    file.write_text(text)
    with pytest.raises(ValueError, match=r"catch\.toml"):
        load_manual(file, NUMBERS)


def test_the_schema_names_every_key() -> None:
    schema = (FOLDER.parent / "SCHEMA.md").read_text(encoding="utf-8")
    assert [field.name for field in fields(Manual) if field.name not in schema.partition("## Manuals")[2]] == []
