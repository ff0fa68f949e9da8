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
    text = f"a = \"{LONG}\" # {LONG}\nb = '{LONG}'\nc = \"\"\"\n{LONG}\n\"\"\"\nd = '''\n{LONG}'''\n# {LONG}\n"
    numbers = f"e = [{'1.5, ' * 100}]\n"
    assert set(read_toml(written(tmp_path, text + numbers), "a manual")) == set("abcde")


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
