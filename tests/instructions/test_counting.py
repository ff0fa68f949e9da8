"""Reading valgrind's totals, and comparing counts of instructions with recorded ones."""

import json
from typing import Any

import pytest
from instructions import counting, game_words

import atari
from atari.games.compiler import compile_rules

BUILD = {"compiler": "GNU 12.2.0", "architecture": "x86_64"}


def record(**instructions: int) -> dict[str, Any]:
    return {**BUILD, "instructions": counts(**instructions)}


def counts(**instructions: int) -> counting.Counts:
    return {game: {"act": value} for game, value in instructions.items()}


def test_the_total_is_read_from_callgrinds_file() -> None:
    assert (
        counting.instructions_in("events: Ir\nfn=(1) main\n16 3\n\nsummary: 151653009\n\ntotals: 151653009\n")
        == 151653009
    )
    assert counting.instructions_in("events: Ir\ntotals: 12\n") == 12


def test_a_file_without_a_total_is_an_error() -> None:
    with pytest.raises(ValueError, match="no total of instructions"):
        counting.instructions_in("events: Ir\nfn=(1) main\n16 3\n")


def test_a_little_more_is_allowed() -> None:
    assert counting.verdict(record(pong=1000), BUILD, counts(pong=1029)) == (
        ["No count has changed by more than 3%."],
        True,
    )


def test_more_than_three_percent_are_not() -> None:
    lines, acceptable = counting.verdict(record(pong=1000, tetris=1000), BUILD, counts(pong=1031, tetris=900))
    assert not acceptable
    assert lines == [
        "Risen by more than 3%: pong (act).",
        "Fallen by more than 3%: tetris (act); --record keeps what was won.",
    ]


@pytest.mark.parametrize("other", [{"compiler": "Clang 14.0.6"}, {"architecture": "aarch64"}])
def test_counts_of_another_build_are_not_compared(other: dict[str, str]) -> None:
    lines, acceptable = counting.verdict(record(pong=1000), {**BUILD, **other}, counts(pong=2000))
    assert acceptable
    assert lines[0].startswith("Not compared: the recorded counts are of GNU 12.2.0 on x86_64, this build is of ")


def test_a_game_without_a_recorded_count_is_named() -> None:
    assert counting.verdict(record(pong=1000), BUILD, counts(pong=1000, krull=5)) == (["Not recorded: krull."], True)


def test_the_table_shows_recorded_counts_new_ones_and_the_change() -> None:
    now = {
        "pong": {"act": 1_020_000, "act, screen_rgb": 1_500_000},
        "krull": {"act": 900_000, "act, screen_rgb": 950_000},
    }
    recorded = {"pong": {"act": 1_000_000}}
    head, names, pong, krull = counting.table(recorded, now).splitlines()
    assert head == "thousands of instructions a frame"
    assert names.split() == "act: recorded now change act, screen_rgb: recorded now change".split()
    assert pong.split() == ["pong", "1000.0", "1020.0", "+2.0%", "-", "1500.0", "-"]
    assert krull.split() == ["krull", "-", "900.0", "-", "-", "950.0", "-"]


def test_a_game_is_described_with_its_rules_and_controllers() -> None:
    game = atari.games.find("breakout")
    lines = dict(line.partition(" ")[::2] for line in game_words.game_words(game).splitlines())
    assert game.rules is not None
    assert lines["step"] == game_words.words(compile_rules(game.rules).step)
    assert (lines["format"], lines["paddles"], lines["minimal_actions"]) == ("NTSC", "1 0", "0 1 3 4")


def test_all_counted_games_are_recorded() -> None:
    recorded = json.loads(counting.RECORD.read_text())
    assert set(recorded["instructions"]) == set(counting.GAMES)
    assert all(set(figures) == set(counting.FIGURES) for figures in recorded["instructions"].values())
