"""`check_game_file`: game definitions with one fault each, and the sentence that each gets.

`tests/games/test_contract.py` has the games of this package.
"""

import shutil
from pathlib import Path

import pytest

import atari
from atari.testing import ContractError, check_game_file

CATCH = Path(__file__).parents[2] / "examples" / "catch"

FAULTS: dict[str, tuple[tuple[str, str], str]] = {
    "no TOML": (("[rules]", "[rules"), "catch.toml:"),
    "an unknown key": (("lives_initial", "lives_at_start"), "[rules] has no key 'lives_at_start'"),
    "an unknown name": (("points - score", "points - scores"), "the name 'scores' is not defined before this line"),
    "over at once": (("ram[0x81] == 0", "ram[0x81] == 3"), "[rules] terminal must be 0 when a game begins, but"),
    "negative lives": (("lives    = ram[0x81]", "lives    = ram[0x81] - 4"), "[rules] lives must be 0 or more, got -1"),
    "a reward that is never paid": (
        ("reward   = points - score", "reward   = 0"),
        "[ram] score_1 is a score and had the values 0..2, but [rules] reward was always 0",
    ),
    "a position beside the screen": (
        ('"v - 16"', '"v + 160"'),
        "[ram] ball_x is a position_x and must be within 0..159",
    ),
    "a mode that cannot be selected": (
        (
            "lives    = ram[0x81]\n'''",
            "lives    = ram[0x81]\n'''\nmode_select = [{op = 'press_select_until', frames = 2, until = 'ram[0x81] == 77'}]",
        ),
        "a reset of catch raised RuntimeError: the mode cannot be selected",
    ),
    "modes that nothing selects": (("modes = [0]", "modes = [0, 1]"), "has 2 modes, and [rules] needs mode_select"),
    "actions that do not matter": (
        ('["NOOP", "RIGHT", "LEFT"]', '["NOOP", "UP", "DOWN"]'),
        "[actions] minimal: NOOP, UP, DOWN lead to the same RAM after 600 frames; no action matters",
    ),
    "a label outside of RAM": (("index = 3", "index = 131"), "[ram] ball_x: index 131 is not within 0..127"),
}


@pytest.fixture
def catch(tmp_path: Path) -> Path:
    for name in ("catch.toml", "catch.bin"):
        shutil.copy(CATCH / name, tmp_path)
    return tmp_path / "catch.toml"


@pytest.mark.parametrize("name", FAULTS)
def test_a_file_with_a_fault_gets_its_sentence(name: str, catch: Path) -> None:
    (old, new), sentence = FAULTS[name]
    text = catch.read_text(encoding="utf-8")
    assert old in text
    catch.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ContractError) as caught:
        check_game_file(catch, rom=catch.with_suffix(".bin"))
    assert sentence in str(caught.value)


def test_a_game_of_ones_own_passes(catch: Path) -> None:
    check_game_file(catch, rom=catch.with_suffix(".bin"))
    check_game_file(str(catch), rom=str(catch.with_suffix(".bin")), steps=100)


def test_what_cannot_be_checked_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="combat has no rules of one player, and check_game_file plays no others"):
        check_game_file(atari.games["combat"])
    with pytest.raises(FileNotFoundError):
        check_game_file(tmp_path / "none.toml")
