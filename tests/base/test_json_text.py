"""JSON of strangers: what is read, and what is refused."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from atari.base import json_text


@pytest.mark.parametrize(
    "value", [None, True, -5, 2**64 - 1, 1.5, "ü\n", [], {"a": [{"b": None}]}, "[[[{" * 40, '\\"[', {"a": "\\"}]
)
def test_good_values(value: Any) -> None:
    assert json_text.parse(json.dumps(value), "x") == value
    assert json_text.parse(json.dumps(value, ensure_ascii=False).encode(), "x") == value


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "x is damaged: Expecting"),
        ("[" * 33 + "]" * 33, "nested more than 32 deep"),
        ("[" * 1_000_000, "nested more than 32 deep"),
        ('"' + "a" * (1 << 20) + '"', "and 1,048,576 are allowed"),
        ("1e999", "the number 1e999 is out of range"),
        ("NaN", "NaN is no number of JSON"),
        ("-Infinity", "-Infinity is no number"),
        ("1" + "0" * 5000, "is out of range"),
        (str(2**64), "the number 18446744073709551616 is out of range"),
        ('{"a": 1, "a": 2}', "the key 'a' is there twice"),
        (r'"\ud800"', "control character"),
        (r'"\u001b]0;x\u0007"', r"has the control character '\\x1b'"),
        (r'{"\u202e": 1}', "a key has the control character"),
        (b'"\xff"', "can't decode byte"),
        ("", "Expecting value"),
    ],
)
def test_refused_texts(text: str | bytes, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        json_text.parse(text, "x")


def test_files(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("[1]")
    assert json_text.read(tmp_path / "a") == [1]
    (tmp_path / "b").write_text("[1, 2, 3]")
    with pytest.raises(ValueError, match=r"b is damaged: it has 6 bytes, and 5 are allowed"):
        json_text.read(tmp_path / "b", most_bytes=5)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ValueError, match="is a device or a pipe"):
        json_text.read(tmp_path / "pipe")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\tb\n", "a\tb\n"),
        ("ü ブ\u00a0x", "ü ブ\u00a0x"),
        ("\x1b]0;x\x07\r\x00\x7f\x9b", r"\x1b]0;x\x07\r\x00\x7f\x9b"),
        ("\u202e\u2028\ud800\U000e0001", r"\u202e\u2028\ud800\U000e0001"),
    ],
)
def test_control_characters_are_escaped(text: str, shown: str) -> None:
    assert json_text.escaped(text) == shown


def test_a_changed_value_of_a_sealed_table_is_found() -> None:
    table = {"a": 1.5, "b": ["x", None]}
    sealed = json_text.parse(json.dumps(json_text.seal(table)), "x")
    assert json_text.check_seal(sealed) == table
    for changed in ({**sealed, "a": 1.25}, {**sealed, "b": ["y", None]}, table, {**sealed, "sha256": 5}):
        with pytest.raises(ValueError, match="its checksum differs"):
            json_text.check_seal(changed)
