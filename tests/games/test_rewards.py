"""The expressions of rewards: the language, its errors, and equality of the compiled formula with plain Python."""

import ast

import numpy as np
import pytest
import reward_reference as reference
from hypothesis import given, settings
from hypothesis import strategies as st
from reward_strategies import expressions

import atari
from atari.cores.compiled import reward_formula
from atari.games.rewards import MOST, compile_reward

RAM = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).integers(0, 256, 128, np.uint8))
GAMES = ("pong", "montezuma_revenge", "seaquest")


def paid(game: str, text: str, now: reference.Moment, before: reference.Moment) -> float:
    """The compiled reward of a step."""
    formula = reward_formula(atari.games[game], text)
    inputs = np.zeros(formula.inputs)
    formula.begin(inputs, before.ram, before.lives)
    inputs[:3] = before.reward, before.lives, before.lives_lost
    return formula.pay(inputs, now.ram, now.lives, now.reward)


@settings(max_examples=400, deadline=None)
@given(game=st.sampled_from(GAMES), data=st.data())
def test_formulas_equal_plain_python(game: str, data: st.DataObject) -> None:
    text = ast.unparse(ast.parse(data.draw(expressions(game)), mode="eval"))
    numbers = st.integers(-1000, 100_000)
    before = reference.Moment(data.draw(RAM), data.draw(st.integers(0, 9)), float(data.draw(numbers)), 1)
    now = reference.after(before, data.draw(RAM), data.draw(st.integers(0, 9)), float(data.draw(numbers)))
    expected = reference.value(game, text, now, before)
    assert paid(game, text, now, before) == expected
    assert np.isfinite(np.float32(expected))


def moment(lives: int = 3, reward: float = 0.0, **bytes_: int) -> reference.Moment:
    ram = np.zeros(128, np.uint8)
    for name, byte in bytes_.items():
        ram[int(name[1:])] = byte
    return reference.Moment(ram, lives, reward)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("reward", 10.0),
        ("reward - 5 * lives_lost", 0.0),
        ("lives - before.lives", -2.0),
        ("before.reward", 0.0),
        ("reward / 4", 2.5),
        ("reward // 4", 2.0),
        ("-reward // 4", -3.0),
        ("-reward % 4", 2.0),
        ("reward % -4", -2.0),
        ("reward / 0", 0.0),
        ("0 / 0", 0.0),
        ("reward // 0", 0.0),
        ("reward % 0", 0.0),
        ("3e38 * 3e38", MOST),
        ("-3e38 - 3e38", -MOST),
        ("3e38 * 3e38 - 3e38 * 3e38", 0.0),
        ("1 / 1e-320", MOST),
        ("7.9 & 3", 3.0),
        ("-1.5 >> 1", -1.0),
        ("1 << 3", 8.0),
        ("3 < reward < 11", 1.0),
        ("3 < reward < 10", 0.0),
        ("reward and 0.5", 0.5),
        ("0 or 0.25", 0.25),
        ("not reward", 0.0),
        ("1 if reward > 9 else 2", 1.0),
        ("min(reward, 3, 7)", 3.0),
        ("max(reward, 3, 70)", 70.0),
        ("abs(-reward)", 10.0),
        ("ram[0x80] - before.ram[0x80]", 250.0),
        ("ram[0] - ram[0x80]", 0.0),
        ("s8(ram[0x80])", -1.0),
        ("before.s8(ram[0x80])", 5.0),
        ("0.1", 0.1),
        ("-0.0", 0.0),
    ],
)
def test_values(text: str, expected: float) -> None:
    found = paid("pong", text, moment(lives=1, reward=10.0, b0=255), moment(b0=5))
    assert found == expected
    assert str(found) == str(expected)


HIDING = "player_y"
SEEN, HIDDEN = {"b51": 100}, {"b51": 0}


def test_a_label_that_is_not_visible_has_the_value_of_the_other_time() -> None:
    label = atari.games["pong"].ram_labels[HIDING]
    assert (label.index, label.visible) == (51, "v > 13")
    seen, hidden, later = moment(**SEEN), moment(**HIDDEN), moment(b51=110)
    value = paid("pong", HIDING, seen, seen)
    difference = f"{HIDING} - before.{HIDING}"
    assert value != 0
    assert paid("pong", difference, later, seen) == 10.0
    assert paid("pong", difference, hidden, seen) == paid("pong", difference, seen, hidden) == 0.0
    assert paid("pong", HIDING, hidden, seen) == paid("pong", f"before.{HIDING}", seen, hidden) == value
    assert paid("pong", HIDING, hidden, hidden) == 0.0
    both = f"visible({HIDING}) + 2 * visible(before.{HIDING})"
    assert [paid("pong", both, *times) for times in ((seen, hidden), (hidden, seen))] == [1.0, 2.0]


def test_lives_are_those_of_the_rules_and_labels_may_be_named_like_functions() -> None:
    assert "lives" in atari.games["breakout"].ram_labels
    assert paid("breakout", "lives", moment(lives=4), moment()) == 4.0
    assert paid("pong", "visible(score_player)", moment(), moment()) == 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "'' is not an expression"),
        ("reward -", "is not an expression: invalid syntax at the end"),
        ("reward - 5 * lives_lst", r"column 14, at 'lives_lst': there is no such name; did you mean 'lives_lost'\?"),
        ("0.1 * (balx - 1)", r"column 8, at 'balx': there is no such name; did you mean 'ball_x'\? .*labels of pong"),
        ("before.qwertz", r"column 1, at 'before.qwertz': there is no such name; accepted are reward, lives, "),
        ("before", "column 1, at 'before': before is followed by a dot and a name"),
        ("before.before.lives", "column 1, at 'before.before.lives': accepted are numbers"),
        ("lives.reward", "column 1, at 'lives.reward': accepted are numbers"),
        ("reward ** 2", r"column 1, at 'reward \*\* 2': accepted are numbers, names, .* / "),
        ("+reward", "column 1, at '.reward': accepted are"),
        ("reward, 1", "at 'reward, 1': accepted are"),
        ("'reward'", "column 1, at \"'reward'\": a number is within"),
        ("True", "at 'True': a number is within"),
        ("1e999", "at '1e999': a number is within"),
        ("1j", "at '1j': a number is within"),
        ("9" * 50, "a number is within"),
        ("reward + open('x')", r"column 10, at \"open\('x'\)\": accepted are"),
        ("(lambda: 1)()", "accepted are"),
        ("[x for x in y]", "accepted are"),
        ("ram", "column 1, at 'ram': accepted are"),
        ("ram[300]", r"column 1, at 'ram\[300\]': an address is a number within 0x0..0xff, not 300"),
        ("ball_x - before.balx", r"at 'before.balx': there is no such name; did you mean 'before.ball_x'\?"),
        ("ram[lives]", r"at 'ram\[lives\]': an address is a number within"),
        ("1 + ram[0x80", r"is not an expression: .* in column 8"),
        ("xram[0x80]", "column 1, at 'xram': a reward reads the console's 128 bytes alone"),
        ("rng()", "column 1, at 'rng': a reward reads"),
        ("bcd()", r"at 'bcd\(\)': bcd\(\) has 0 arguments"),
        ("s8(ball_x)", r"column 4, at 'ball_x': an argument of s8\(\) is a number or ram"),
        ("abs(1, 2)", r"at 'abs\(1, 2\)': this function takes 1 value"),
        ("min(1)", "this function takes 2 to 8 values"),
        ("visible(lives)", r"column 9, at 'lives': visible\(\) takes a RAM label of pong"),
        ("visible(1)", r"visible\(\) takes"),
        ("reward # all", "column 8, at '#': an expression has no comments"),
        ("é + reward", "column 1, at 'é': there is no such name"),
        ("reward + é", "column 10, at 'é'"),
        ("reward\x00", "is not an expression"),
        ("\ud800", "is not an expression"),
        ("1 + " * 400 + "1", "nested too deeply"),
        ("(" * 300 + "1" + ")" * 300, "is not an expression|nested too deeply"),
        ("1" + " " * 2000, "at most 2,000 characters"),
        (" + ".join(f"ram[{address}]" for address in range(0x80, 0xC1)), "reads 65 numbers of RAM, and at most 64 fit"),
    ],
)
def test_errors_have_their_place(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=f"^reward: .*{message}"):
        compile_reward(atari.games["pong"], text)


def test_the_deepest_expressions_are_evaluated() -> None:
    deep = "1 if lives > 3 else " * 90 + "reward"
    assert paid("pong", deep, moment(reward=7.0), moment()) == 7.0
    with pytest.raises(ValueError, match="too large for the emulator"):
        reward_formula(atari.games["pong"], f"s8({'1 + (' * 40}ram[0x80]{')' * 40})")


def test_every_label_of_every_game_can_be_named() -> None:
    for game in map(atari.games.__getitem__, atari.games):
        names = list(game.ram_labels)
        for start in range(0, len(names), 16):
            reward_formula(game, " + ".join(names[start : start + 16]))


def test_a_forged_state_gives_finite_rewards() -> None:
    formula = reward_formula(atari.games["pong"], "before.reward * 2 + before.ball_x")
    ram = np.zeros(128, np.uint8)
    for wrong in (np.nan, np.inf, -np.inf, 1e308):
        assert np.isfinite(formula.pay(np.full(formula.inputs, wrong), ram, 3, wrong))


def test_the_extension_module_checks_formulas() -> None:
    formula = reward_formula(atari.games["pong"], "reward")
    make = type(formula)
    end = compile_reward(atari.games["pong"], "reward").terms
    for terms, visibility, words, constants in (
        (end, [], [], []),
        (end, [], [0], []),
        (end, [], [1, 0], []),
        (end, [], [99, 0], []),
        (end, [], [0, 6], []),
        (end, [], [0, -1], []),
        (end, [], [0, 0, 0, 0], []),
        (end, [], [0, 0] * 300, []),
        (end, [7], [0, 0], []),
        (end, [-2], [0, 0], []),
        ([], [], [0, 0], []),
    ):
        with pytest.raises(ValueError, match=r"\w"):
            make(terms, visibility, words, constants)
    with pytest.raises(ValueError, match="a number for each input"):
        formula.pay(np.zeros(1), np.zeros(128, np.uint8), 0, 0.0)
    with pytest.raises(ValueError, match="128"):
        formula.begin(np.zeros(3), np.zeros(127, np.uint8), 0)
