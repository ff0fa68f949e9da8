"""The one reader of JSON that may come from a stranger."""

import hashlib
import json
import math
import re
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from atari.base.validation import check_file

_STRING = re.compile(r'"(?:[^"\\]|\\.)*"?', re.DOTALL)
_SPACES = str.maketrans("", "", "\n\t\u00a0\u2009\u202f\u3000")
"""Line feeds, tabs, and spaces of other widths, which `str.isprintable` refuses."""


def parse(
    text: str | bytes, what: str, *, most_bytes: int = 1 << 20, most_depth: int = 32, most_number: int = 2**64
) -> Any:
    """The value of a JSON text, with bounded size, depth and numbers, and texts that a terminal can show.

    Args:
        text: the text; bytes are UTF-8.
        what: the beginning of messages, such as "run/config.json".
        most_bytes: the most bytes of the text.
        most_depth: the most lists and objects within each other.
        most_number: the bound of whole numbers.

    Raises:
        ValueError: the text is not JSON, or beyond a bound; a key is double; a number is infinite or no number, or a
            whole number of `most_number` or more; a text has control characters.
    """
    try:
        data = text.encode() if isinstance(text, str) else text
        if len(data) > most_bytes:
            raise ValueError(f"it has {len(data):,} bytes, and {most_bytes:,} are allowed")
        decoded = data.decode()
        _check_depth(decoded, most_depth)
        value = json.loads(
            decoded,
            object_pairs_hook=_table,
            parse_constant=_constant,
            parse_int=partial(_integer, most=most_number),
            parse_float=_float,
        )
        _check_texts(value, most_bytes)
    except ValueError as error:  # json.JSONDecodeError and UnicodeError are ValueErrors
        raise ValueError(f"{what} is damaged: {error}") from None
    return value


def read(path: Path, *, what: str | None = None, most_bytes: int = 1 << 20, most_depth: int = 32) -> Any:
    """The value of a JSON file; see `parse`. The messages begin with `what`, or with the path.

    Raises:
        FileNotFoundError, OSError: there is no such file, or it cannot be read.
        ValueError: see `parse`; or the path names a folder, a pipe or a device.
    """
    check_file(path)
    with path.open("rb") as file:
        return parse(file.read(most_bytes + 1), what or str(path), most_bytes=most_bytes, most_depth=most_depth)


def check_text(text: str, what: str, most: int = 1000) -> str:
    """`text`, if it is short enough and a terminal can show it.

    Raises:
        ValueError: it is too long, or has control characters other than line feeds and tabs, or half a
            character.
    """
    if len(text) > most:
        raise ValueError(f"{what} has {len(text):,} characters, and {most:,} are allowed")
    if not text.translate(_SPACES).isprintable():
        bad = next(character for character in text.translate(_SPACES) if not character.isprintable())
        raise ValueError(f"{what} has the control character {bad!r}: {text!r:.60}")
    return text


def escaped(text: str) -> str:
    """`text` for a terminal: control characters other than line feeds and tabs as escapes such as \\x1b."""
    shown = (one if one.translate(_SPACES).isprintable() else one.encode("unicode_escape").decode() for one in text)
    return "".join(shown)


def seal(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table with its checksum under the key "sha256", which `check_seal` compares."""
    return {**table, "sha256": _digest(table)}


def check_seal(table: Mapping[str, Any]) -> dict[str, Any]:
    """The table that `seal` was given.

    Raises:
        ValueError: the checksum is missing or differs.
    """
    rest = {key: value for key, value in table.items() if key != "sha256"}
    if table.get("sha256") != _digest(rest):
        raise ValueError("its checksum differs: the file was changed after it was written")
    return rest


def _digest(table: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(table, sort_keys=True).encode()).hexdigest()


def _check_depth(text: str, most: int) -> None:
    depth = 0
    for character in re.sub(r"[^\[\]{}]+", "", _STRING.sub("", text)):
        depth += 1 if character in "[{" else -1
        if depth > most:
            raise ValueError(f"its lists and objects are nested more than {most} deep")


def _table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise ValueError(f"the key {key!r:.60} is there twice")
        table[key] = value
    return table


def _constant(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")


def _integer(digits: str, most: int) -> int:
    if len(digits) > 1000 or abs(int(digits)) >= most:
        raise ValueError(f"the number {digits:.30} is out of range")
    return int(digits)


def _float(digits: str) -> float:
    number = float(digits)
    if not math.isfinite(number):
        raise ValueError(f"the number {digits:.30} is out of range")
    return number


def _check_texts(value: Any, most: int) -> None:
    if isinstance(value, str):
        check_text(value, "a text", most)
    elif isinstance(value, dict):
        for key, one in value.items():
            check_text(key, "a key")
            _check_texts(one, most)
    elif isinstance(value, list):
        for one in value:
            _check_texts(one, most)
