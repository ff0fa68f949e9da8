"""TOML files of users: limits on their size and keys, which are checked before the parser reads them."""

from pathlib import Path

import pytest

import atari
from atari.games.game import load_game
from atari.games.manual import load_manual
from atari.games.toml_file import MOST_PARTS, read_toml
from atari.lab import interventions

LONG = ".".join("a" * 20_000)


def written(folder: Path, text: str) -> Path:
    file = folder / "mine.toml"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    "text",
    [
        f"{LONG} = 1",
        f"[{LONG}]",
        f"[[{LONG}]]",
        f"x = {{{LONG} = 1}}",
        f"x = [{{ {LONG.replace('.', ' . ')} = 1 }}]",
        LONG.replace("a", "'a.a'") + " = 1",
        LONG.replace("a", '"\\"."') + " = 1",
        f'text = """\n"quoted" \\""" # no comment\n""" # "\n{LONG} = 1',
        f"text = '''\n''' # '''\n{LONG} = 1",
        f"text = 'C:\\'\n{LONG} = 1",
    ],
)
def test_a_key_of_many_parts_is_refused_before_it_is_parsed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    monkeypatch.setattr("atari.games.toml_file.tomllib.loads", None)  # it takes ten seconds
    line = text.count("\n") + 1
    with pytest.raises(ValueError, match=rf"mine\.toml: line {line} has a key of 20,000 parts .* at most 32; use"):
        read_toml(written(tmp_path, text), "a manual")


def test_every_kind_of_file_is_checked(tmp_path: Path) -> None:
    file = written(tmp_path, f"{LONG} = 1")
    for read in (
        lambda: load_game(file),
        lambda: load_manual(file, {}),
        lambda: interventions.load("pong", file),
        lambda: atari.AtariEnv(file),
        lambda: atari.AtariEnv("pong", interventions=[f"{file}#name"]),
    ):
        with pytest.raises(ValueError, match="at most 32"):
            read()


def test_texts_may_have_any_number_of_dots(tmp_path: Path) -> None:
    dots = LONG[:1999]
    text = f"a = \"{dots}\" # {LONG}\nb = '{dots}'\nstep = \"\"\"\n{dots}\n\"\"\"\nd = '''\n{dots}'''\n# {LONG}\n"
    numbers = f"e = [{'1.5, ' * 100}]\n"
    assert set(read_toml(written(tmp_path, text + numbers), "a manual")) == {"a", "b", "step", "d", "e"}


def test_a_key_may_have_as_many_parts_as_the_message_says(tmp_path: Path) -> None:
    key = ".".join("a" * MOST_PARTS)
    assert list(read_toml(written(tmp_path, f"{key} = 1"), "a manual")) == ["a"]
    with pytest.raises(ValueError, match="33 parts"):
        read_toml(written(tmp_path, f"{key}.a = 1"), "a manual")


@pytest.mark.parametrize(
    "text", ["'" * 60_001, '"' * 60_001, '"\\' * 60_000, ("." * 40 + "\n") * 3000, '"""' + "a." * 60_000]
)
def test_what_is_no_toml_is_refused_by_the_parser(tmp_path: Path, text: str) -> None:
    with pytest.raises(ValueError, match=r"mine\.toml"):
        read_toml(written(tmp_path, text), "a manual")


BREAKOUT = (Path(atari.games.__path__[0]) / "data" / "breakout.toml").read_text(encoding="utf-8")
CONTROLS = ["\\u001b]0;changed\\u0007", "\\u0000", "\\u009b31m", "\\r", "\\b", "\\u202e", "\\u2028", "\\U000e0001"]


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ('title = "Breakout"', 'title = "BreakoutX"', "title"),
        ("notes = [", 'notes = ["X", ', r"notes\[0\]"),
        ('evidence = "confirmed"', 'evidence = "X"', r"ram\.\w+\.evidence"),
        ('sources = ["', 'sources = ["X', r"ram\.\w+\.sources\[0\]"),
        ("[ram]\n", '[ram]\n"X" = {index = 1, kind = "other", sources = [], evidence = "a"}\n', "a key of ram"),
        ("[ram]\n", '[ram]\na = {index = 1, kind = "other", sources = [], evidence = "a", note = "X"}\n', "ram.a.note"),
        ("[settings]\n", '[settings]\n"X" = 1\n', "a key of settings"),
    ],
)
def test_a_control_character_is_refused_with_its_place(
    tmp_path: Path, control: str, old: str, new: str, place: str
) -> None:
    assert old in BREAKOUT
    file = written(tmp_path, BREAKOUT.replace(old, new.replace("X", control), 1))
    with pytest.raises(ValueError, match=rf"mine\.toml: {place} has the control character '") as refused:
        load_game(file)
    assert str(refused.value).isprintable()


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('title = "a\\n[x]"', "title must be one line without tabs"),
        ('title = "a\\tb"', "title must be one line without tabs"),
        ('"a\\nb" = 1', "a key of the file must be one line"),
        ('"a\\tb" = 1', "a key of the file must be one line"),
        (f'title = "{"a" * 2001}"', "title has 2,001 characters, and 2,000 are allowed"),
        (f"[rules]\nstep = '{'a' * 20_001}'", "rules.step has 20,001 characters, and 20,000 are allowed"),
        (f"{'a' * 101} = 1", "a key of the file has 101 characters, and 100 are allowed"),
    ],
)
def test_texts_are_bounded(tmp_path: Path, text: str, fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        read_toml(written(tmp_path, text), "a manual")


def test_an_intervention_with_a_control_character_is_refused(tmp_path: Path) -> None:
    text = '[a]\ndescription = "\\u001b[0m"\nsource = "own"\nwrites = [{to = 3, value = 1}]\n'
    with pytest.raises(ValueError, match=r"mine\.toml: a\.description has the control character"):
        interventions.load("pong", written(tmp_path, text))
