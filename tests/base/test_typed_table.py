"""Checks of tables and values against declared types, and values read from texts."""

from dataclasses import dataclass
from typing import Any, Literal

import pytest

from atari.base.typed_table import build, check_table, fits, from_text, in_text, in_words

KINDS = {"a": int, "b": str | None}
GOOD = {"a": 1, "b": None, "c": 2}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ([], "x must be a table, got []"),
        ({"a": 1}, "x needs the key 'b'"),
        ({**GOOD, "d": 1}, "x has no key 'd'; it can have a, b, cause"),
        ({**GOOD, "caus": 1}, "x has no key 'caus'; did you mean 'cause'? it can have a, b, cause"),
        ({**GOOD, "a": True}, "x: 'a' must be a whole number, got True"),
        ({**GOOD, "a": 1.0}, "x: 'a' must be a whole number, got 1.0"),
        ({**GOOD, "b": 1}, "x: 'b' must be a text or none, got 1"),
        ({**GOOD, 3: "y" * 100}, "x has no key 3; it can have a, b, cause"),
        ({**GOOD, "cause": "y" * 100}, f"x: 'cause' must be a number, got '{'y' * 59}"),
    ],
)
def test_tables(table: Any, message: str) -> None:
    good = {"a": 1, "b": None, "cause": 2}
    assert check_table(good, "x", KINDS, {"cause": float}) == good
    changed = {key: value for key, value in table.items() if key != "c"} if isinstance(table, dict) else table
    with pytest.raises(ValueError) as error:  # noqa: PT011 - the whole message is compared
        check_table(changed, "x", KINDS, {"cause": float})
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("kind", "words", "good", "bad"),
    [
        (int, "a whole number", [0, -1], [True, 1.0, "1", None]),
        (float, "a number", [1, 1.5], [False, "1"]),
        (bool, "true or false", [True, False], [0, 1, None]),
        (str, "a text", ["", "x"], [None, b"x"]),
        (dict, "a table", [{}], [[], None]),
        (list, "a list", [[], ()], [{}, "x"]),
        (None, "none", [None], [0, False]),
        (int | None, "a whole number or none", [3, None], [False, ""]),
        (tuple[int, ...], "a list of whole numbers", [[], [1, 2], (1,)], [1, "12", [True], [1.0]]),
        (tuple[int, int], "a list of 2 whole numbers", [[1, 2]], [[1], [1, 2, 3], 5]),
        (tuple[dict[str, Any], ...], "a list of tables", [[], [{}]], [[1], {}]),
        (Literal["auto", True, False], "one of auto, true, false", ["auto", True], [1, 0, "true"]),
        (Any, "Any", [None, object()], []),
    ],
)
def test_types(kind: Any, words: str, good: list[Any], bad: list[Any]) -> None:
    assert in_words(kind) == words
    assert all(fits(value, kind) for value in good)
    assert not any(fits(value, kind) for value in bad)


@dataclass(frozen=True)
class Row:
    name: str
    places: tuple[int, ...] = ()


def test_a_dataclass_is_built_from_a_table() -> None:
    assert build(Row, {"name": "x", "places": [1, 2]}, "[row]") == Row("x", (1, 2))
    assert build(Row, {"name": "x"}, "[row]") == Row("x")
    with pytest.raises(ValueError, match=r"^\[row\] needs the key 'name'$"):
        build(Row, {}, "[row]")


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("1e6", int, 1_000_000),
        ("9007199254740993", int, 9007199254740993),
        ("1.5", int, 1.5),
        ("18", float | None, 18.0),
        ("none", float | None, None),
        ("none", int, "none"),
        ("true", bool, True),
        ("yes", bool, "yes"),
        ("auto", Literal["auto", True, False], "auto"),
        ("false", Literal["auto", True, False], False),
        ("2,5", int | tuple[int, int], (2, 5)),
        ("2,x", int | tuple[int, int], (2, "x")),
        ("3", tuple[int, int], 3),
        ("0.5,0", float | tuple[float, ...], (0.5, 0.0)),
        ("A,B", str | tuple[str, ...], ("A", "B")),
        ("a, b", str | None, "a, b"),
        ("3", str | None, "3"),
    ],
)
def test_a_text_on_a_command_line(text: str, kind: Any, value: Any) -> None:
    found = from_text(text, kind)
    assert found == value
    assert type(found) is type(value)
    assert from_text(in_text(value), kind) == value
