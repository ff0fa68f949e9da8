"""The language of game rules: accepted and refused expressions, and the error message for each mistake."""

from typing import Any

import pytest
from rules_interpreter import Interpreter, evaluate

import atari
from atari.games.rules import HELPERS, LABEL_ADDRESSES, check_expression, parse_rules

RAM = bytes(range(128))  # address 0x80 + i holds i


def rules_table(**changes: Any) -> dict[str, Any]:
    step = "reward = ram[0x80] - score\nscore = ram[0x80]\nterminal = ram[0x81] == 0\nlives = 1"
    return {"lives_initial": 1, "state": {"score": 0}, "step": step, **changes}


def test_every_expression_of_every_game_is_in_the_language() -> None:
    count = 0
    for game in atari.games.playable():
        assert game.rules is not None
        scope = set(game.rules.state)
        for name, source in game.rules.step:
            check_expression(source, scope, game.id)
            scope.add(name)
            count += 1
        assert {"reward", "terminal", "lives"} <= {name for name, _ in game.rules.step}, game.id
    assert count > 500


@pytest.mark.parametrize(
    ("source", "value"),
    [
        ("0x10 + 2 * 3 - 1", 21),
        ("ram[0x85]", 5),
        ("ram[0xFF] // 10 % 7", 5),
        ("(ram[0xFF] >> 4) | (1 << 4) ^ 3 & ~2", 23),
        ("-ram[0x81]", -1),
        ("1 if ram[0x80] == 0 and not ram[0x81] != 1 or 0 else 2", 1),
        ("0 < ram[0x81] <= 1", 1),
        ("x * 2", 14),
        ("bcd(0x92, 0x91)", 100 * 11 + 12),
        ("bcd(0xFF)", 7 * 10 + 15),
        ("s8(0xFF)", -1),
        ("s8(ram[0xFF])", 127),
        ("count(0x80, 0x8F, 3, 7, 99)", 2),
        ("same(0x80, 0x81)", 0),
        ("same(0x80, 0x80)", 1),
        ("pos_sum(0x81, 0x83)", 6),
        ("neg_sum(0x81, 0x83)", 0),
    ],
)
def test_what_an_expression_is_worth(source: str, value: int) -> None:
    check_expression(source, {"x"}, "here")
    assert evaluate(source, RAM, {"x": 7}) == value


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("1 +", "is not an expression: invalid syntax"),
        ("", "is not an expression"),
        ("x = 1", "is not an expression"),
        ("1; 2", "is not an expression"),
        ("y", "the name 'y' is not defined before this line"),
        ("1.5", "1.5 is not an integer of 32 bits"),
        ("'a'", "'a' is not an integer of 32 bits"),
        ("True", "True is not an integer of 32 bits"),
        ("2147483648", "2147483648 is not an integer of 32 bits"),
        ("2 ** 3", "Pow is not part of the language"),
        ("1 / 2", "Div is not part of the language"),
        ("x @ x", "MatMult is not part of the language"),
        ("x in (1, 2)", "In is not part of the language"),
        ("(1, 2)", "Tuple is not part of the language"),
        ("x is x", "Is is not part of the language"),
        ("[1]", "List is not part of the language"),
        ("{1: 2}", "Dict is not part of the language"),
        ("lambda: 1", "Lambda is not part of the language"),
        ("[i for i in x]", "ListComp is not part of the language"),
        ("(y := 1)", "NamedExpr is not part of the language"),
        ("f'{x}'", "JoinedStr is not part of the language"),
        ("await x", "Await is not part of the language"),
        ("x.real", "Attribute is not part of the language"),
        ("__import__('os')", "__import__() is not one of the helpers bcd, s8, count"),
        ("x.bit_length()", "x.bit_length() is not one of the helpers"),
        ("bcd(a=0x80)", "bcd() is not one of the helpers"),
        ("bcd()", "bcd() has 0 arguments"),
        ("same(0x80)", "same() has 1 arguments"),
        ("s8(1, 2)", "s8() has 2 arguments"),
        ("count(0x80, 0x81)", "count() has 2 arguments"),
        ("bcd(x)", "an address is a number within 0x80..0xff, not x"),
        ("same(0x80, 0x100)", "an address is a number within 0x80..0xff, not 256"),
        ("ram[0x7F]", "an address is a number within 0x80..0xff, not 127"),
        ("ram[-1]", "an address is a number within 0x80..0xff, not -1"),
        ("ram[x]", "an address is a number within 0x80..0xff, not x"),
        ("ram[0x80:0x82]", "an address is a number within 0x80..0xff, not 128:130"),
        ("x[0x80]", "only ram[...] and xram[...] can be indexed"),
        ("ram", "the name 'ram' is not defined"),
        ("bcd", "the name 'bcd' is not defined"),
        ("ram[0x80][0x80]", "only ram[...] and xram[...] can be indexed"),
    ],
)
def test_what_is_outside_the_language_is_refused(source: str, problem: str) -> None:
    with pytest.raises(ValueError, match=r"^here: ") as error:
        check_expression(source, {"x"}, "here")
    assert problem in str(error.value)


def test_a_deeply_nested_expression_is_refused_not_fatal() -> None:
    with pytest.raises((ValueError, RecursionError, MemoryError)):
        check_expression("(" * 10_000 + "1" + ")" * 10_000, (), "here")


def test_labels_count_addresses_from_zero() -> None:
    check_expression("v + ram[127]", {"v"}, "here", LABEL_ADDRESSES)
    with pytest.raises(ValueError, match=r"an address is a number within 0x0\.\.0x7f, not 128"):
        check_expression("ram[128]", {"v"}, "here", LABEL_ADDRESSES)
    assert set(HELPERS) == {"bcd", "s8", "count", "same", "pos_sum", "neg_sum", "rng"}  # the interpreter's


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"speed": 1}, "[rules] has no key 'speed'"),
        ({"lives_initial": "3"}, "[rules]: 'lives_initial' must be a whole number, got '3'"),
        ({"state": {"score": 0.5}}, "[rules] state: score must be a whole number, got 0.5"),
        ({"selection_frames": True}, "[rules]: 'selection_frames' must be a whole number, got True"),
        ({"step": 3}, "[rules]: 'step' must be a text, got 3"),
        ({"step": "reward = 1\nterminal = 0"}, "[rules] step never assigns 'lives'"),
        ({"step": "reward = 1\nlives = 1"}, "[rules] step never assigns 'terminal'"),
        ({"step": "terminal = 0\nlives = 1"}, "[rules] step never assigns 'reward'"),
        ({"step": "reward"}, "[rules] step, line 1: expected 'name = expression', got 'reward'"),
        ({"step": "lives = 1\n2x = 1"}, "[rules] step, line 2: expected 'name = expression', got '2x = 1'"),
        ({"step": "ram = 1"}, "[rules] step, line 1: 'ram' has a meaning in the language and cannot be assigned"),
        ({"step": "bcd = 1"}, "[rules] step, line 1: 'bcd' has a meaning in the language and cannot be assigned"),
        ({"step": "reward = later\nlater = 1"}, "line 1: in 'later', the name 'later' is not defined before this line"),
        ({"kept_over_reset": ["timer"]}, "[rules] kept_over_reset names 'timer', which is not in state"),
        *(
            ({"mode_select": [operation]}, text)
            for operation, text in (
                ({"op": "wait"}, "op must be one of set, press_select, press_select_until, soft_reset, act, "),
                ({"frames": 2}, "repeat_until, repeat, got None"),
                ({"op": "soft_reset", "times": 2}, "soft_reset has no key 'times'; it can have none"),
                ({"op": "press_select"}, "press_select needs the key 'frames'"),
                ({"op": "act", "action": "RESET", "times": 1}, "act: 'action' must be one of NOOP, FIRE, UP, "),
                (
                    {"op": "press_select_until", "frames": 2, "until": "ram[0x80] == mood"},
                    "press_select_until until: in 'ram[0x80] == mood', the name 'mood' is not defined",
                ),
                ({"op": "repeat", "times": 2, "do": [{"op": "jump"}]}, "repeat_until, repeat, got 'jump'"),
            )
        ),
        *(({key: None}, f"[rules] needs the key '{key}'") for key in ("lives_initial", "state", "step")),
    ],
)
def test_a_broken_table_is_refused(changes: dict[str, Any], text: str) -> None:
    table = {key: value for key, value in rules_table(**changes).items() if value is not None}
    with pytest.raises(ValueError, match=r"^\[rules\]( mode_select,)?") as error:
        parse_rules(table)
    assert text in str(error.value)


def test_operations_are_kept_in_order_with_what_they_contain() -> None:
    operations = [
        {"op": "set", "var": "before", "value": "ram[0x80]"},
        {"op": "repeat_until", "until": "ram[0x80] != before", "do": [{"op": "act", "action": "UP", "times": 2}]},
        {"op": "press_select_until", "frames": "2 + rng() % 8", "until": "mode == 1", "max": 20},
    ]
    first, second, third = parse_rules(rules_table(mode_select=operations)).mode_select
    assert (first.op, first.var, first.value) == ("set", "before", "ram[0x80]")
    assert (second.do[0].action, second.do[0].times) == ("UP", "2")
    assert (third.frames, third.max) == ("2 + rng() % 8", 20)


def test_later_lines_see_earlier_ones_and_state_lasts() -> None:
    interpreter = Interpreter(parse_rules(rules_table()))
    assert interpreter.reset(bytes([5, 1]) + bytes(126), mode=0)["score"] == 5
    assert interpreter.step(bytes([9, 1]) + bytes(126)) == {"reward": 4, "score": 9, "terminal": 0, "lives": 1}
    assert interpreter.step(bytes([9, 0]) + bytes(126)) == {"reward": 0, "score": 9, "terminal": 1, "lives": 1}
