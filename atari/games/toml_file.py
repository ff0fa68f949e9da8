"""`read_toml`: the tables of a TOML file that may come from a stranger: limits on the parser's work, and on texts."""

import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from atari.base.json_text import check_text
from atari.base.validation import check_file

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOST_BYTES = 256 << 10
MOST_PARTS = 32
"""The most parts of a key; `screen.colours.first` has 3. The parser's time grows with the square of their number."""

MOST_KEY, MOST_LINE, MOST_LINES = 100, 2000, 20_000
"""The most characters of a key, of a text of one line, and of a text of several lines."""
_DEEPEST = 40
_OF_LINES = ("step", "corrected_step", "description")
"""The keys whose texts may have several lines."""

_STRING = r""""(?:[^"\\\n]|\\.)*"?|'[^'\n]*'?"""  # an unterminated string ends with its line
_KEY = rf"(?:[A-Za-z0-9_-]+|{_STRING})(?:[ \t]*\.[ \t]*(?:[A-Za-z0-9_-]+|{_STRING}))*"
_TOKEN = re.compile(
    rf"""(?P<other>\#[^\n]*|\"""(?:[^\\]|\\[\s\S])*?(?:\"""|\Z)|'''[\s\S]*?(?:'''|\Z))|(?P<key>{_KEY})"""
)
_PART = re.compile(rf"[A-Za-z0-9_-]+|{_STRING}")


def read_toml(path: Path, kind: str) -> dict[str, Any]:
    """The tables of a file; `kind` names the kind of file in errors, such as "a manual".

    Raises:
        ValueError: the file has more than `MOST_BYTES` bytes, a key of more than `MOST_PARTS` parts, or is not valid
            TOML; a text is too long, or has control characters, or several lines where one is expected; tables and
            lists are nested too deeply. The message names the file and the place. Or it is a device or a pipe.
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.
    """
    check_file(path)
    with path.open("rb") as stream:
        data = stream.read(MOST_BYTES + 1)
    try:
        if len(data) > MOST_BYTES:
            raise ValueError(f"{kind} has at most {MOST_BYTES:,} bytes")
        text = data.decode("utf-8")
        _check_keys(text)
        tables: dict[str, Any] = tomllib.loads(text)
        _check_texts(tables, "")
        return tables
    except RecursionError:
        raise ValueError(f"{path}: its tables or lists are nested too deeply") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def check_numbers(value: Any, where: str) -> None:
    """Check that all numbers in a value fit in the emulator's 32 bits."""
    if isinstance(value, int) and not -(2**31) <= value < 2**31:
        raise ValueError(f"{where} is not an integer of 32 bits")
    for key, item in value.items() if isinstance(value, Mapping) else enumerate(value) if type(value) is list else ():
        check_numbers(item, f"{where}.{key}" if where else str(key))


def check_paddle_range(table: str, value: Any) -> tuple[int, int] | None:
    """The key `paddle_range` of a table, a pair of whole numbers, or None."""
    if value is None:
        return None
    low, high = value
    if not 0 <= low <= high <= 2**24:
        raise ValueError(f"{table} paddle_range must be two integers within 0..{2**24}, got {low}, {high}")
    return low, high


def _check_keys(text: str) -> None:
    """Refuse keys of too many parts. A key is in one line, so a count of dots suffices for most files."""
    if all(line.count(".") < MOST_PARTS for line in text.split("\n")):
        return
    for token in _TOKEN.finditer(text):
        if token["key"] is None or token["key"].count(".") < MOST_PARTS:
            continue
        parts = len(_PART.findall(token["key"]))
        if parts > MOST_PARTS:
            line = text.count("\n", 0, token.start()) + 1
            raise ValueError(
                f"line {line} has a key of {parts:,} parts between dots; a key has at most {MOST_PARTS}; "
                "use fewer levels of tables"
            )


def _check_texts(value: Any, place: str, depth: int = 0) -> None:
    """Check all texts of a value, keys included; `place` names it in errors, such as "ram.ball_x.note"."""
    if depth > _DEEPEST:
        raise ValueError(f"{place} is nested too deeply")
    if isinstance(value, str):
        if place.rpartition(".")[2] in _OF_LINES:
            check_text(value, place, MOST_LINES)
        else:
            _check_line(value, place, MOST_LINE)
    elif isinstance(value, dict):
        for key, one in value.items():
            _check_line(key, f"a key of {place or 'the file'}", MOST_KEY)
            _check_texts(one, f"{place}.{key}" if place else key, depth + 1)
    elif isinstance(value, list):
        for number, one in enumerate(value):
            _check_texts(one, f"{place}[{number}]", depth + 1)


def _check_line(text: str, place: str, most: int) -> None:
    check_text(text, place, most)
    if "\n" in text or "\t" in text:
        raise ValueError(f"{place} must be one line without tabs, got {text!r:.60}")
