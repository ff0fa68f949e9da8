"""`Manual`, the facts of a game for people: the content of a file of `atari/games/manuals/`, parsed and checked.

`atari/games/SCHEMA.md` documents the files. `Game.manual` reads a game's file at its first use.
"""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from atari.base.frozen import FrozenDict
from atari.base.typed_table import check_table, check_type
from atari.games.toml_file import check_numbers, read_toml

SOURCES = ("manual", "play", "rules", "general knowledge")
"""The sources of a fact: the cartridge's manual, the running game, the rules in the game definition, or facts
generally known of the game."""

_TEXTS = ("title", "maker", "description", "reward", "lives", "end")
_NUMBERED = ("modes", "difficulties", "multiplayer_modes")
_FACTS = (*_TEXTS, "year", *_NUMBERED, "notes")


@dataclass(frozen=True)
class Manual:
    """The content of a game's manual, in our own words.

    Example:
        >>> import atari
        >>> manual = atari.games["freeway"].manual
        >>> manual.title, manual.year, manual.maker
        ('Freeway', 1981, 'Activision')

    Attributes:
        title: the title on the cartridge.
        year: the year of the release for the 2600, None if unknown.
        maker: the publisher of the cartridge, None if unknown.
        description: the player's task, the scores, the end of the game.
        modes: meaning by mode number, for the modes whose meaning is known.
        difficulties: meaning by difficulty number, for those whose meaning is known.
        multiplayer_modes: meaning by mode number of `Game.multiplayer`, which has numbers of its own.
        reward, lives, end: the rewards, the lives, and the end of an episode, a sentence each, or None.
        sources: the sources of these attributes by name: some of "manual", "play" (found by running the game), "rules"
            (read from the game definition) and "general knowledge".
        notes: peculiarities, and differences between the rules of ALE and of the cartridge.
    """

    title: str
    year: int | None
    maker: str | None
    description: str
    modes: Mapping[int, str]
    difficulties: Mapping[int, str]
    multiplayer_modes: Mapping[int, str]
    reward: str | None
    lives: str | None
    end: str | None
    sources: Mapping[str, tuple[str, ...]]
    notes: tuple[str, ...]


def load_manual(path: Path, numbers: Mapping[str, Collection[int]]) -> Manual:
    """Read a file of `atari/games/manuals/`.

    Args:
        path: the file.
        numbers: the numbers that the game has, by "modes", "difficulties" and "multiplayer_modes".

    Raises:
        ValueError: the file is not valid TOML, lacks a key, has an unknown key or a wrong type, or has a number that is
            not in `numbers`; the message names the file and the key.
        FileNotFoundError, IsADirectoryError, PermissionError: the file cannot be read.
    """
    table = read_toml(path, "a manual")
    try:
        return parse_manual(table, numbers)
    except (ValueError, TypeError, AttributeError) as error:
        raise ValueError(f"{path}: {error}") from error


def parse_manual(table: Mapping[str, Any], numbers: Mapping[str, Collection[int]]) -> Manual:
    """A `Manual` from the parsed content of a file; `numbers` and the errors are those of `load_manual`."""
    check_numbers(table, "")
    kinds = {"year": int, "notes": tuple[str, ...], **dict.fromkeys(_TEXTS, str)}
    facts = {key: kinds.get(key, dict) for key in _FACTS}
    check_table(table, "the file", {"title": str, "description": str, "sources": dict}, facts)
    for key in _TEXTS:
        if not table.get(key, key).strip():
            raise ValueError(f"{key} is empty; leave it out")
    texts = {key: " ".join(table[key].split()) for key in _TEXTS if key in table}
    given: dict[str, Any] = {key: texts.get(key) for key in _TEXTS}
    given |= {key: _meanings(f"[{key}]", table.get(key, {}), numbers[key]) for key in _NUMBERED}
    return Manual(**given, year=table.get("year"), sources=_sources(table), notes=tuple(table.get("notes", [])))


def _meanings(where: str, table: Any, allowed: Collection[int]) -> FrozenDict[int, str]:
    """Meanings by number. The keys are the game's numbers in decimal, without signs or leading zeros."""
    for key, text in table.items():
        if not re.fullmatch("0|[1-9][0-9]{0,8}", key) or int(key) not in allowed:
            listed = ", ".join(map(str, allowed)) or "none"
            raise ValueError(f"{where} {key} is not a number that the game has ({listed})")
        if not check_type(text, f"{where} {key}", str).strip():
            raise ValueError(f"{where} {key} is empty; leave it out")
    return FrozenDict(sorted((int(key), text) for key, text in table.items()))


def _sources(table: Mapping[str, Any]) -> FrozenDict[str, tuple[str, ...]]:
    """The sources by fact, for facts in the file; texts, modes and difficulties need a source."""
    sources = table["sources"]
    present = [key for key in _FACTS if key in table]
    kinds = dict.fromkeys(present, tuple[str, ...])
    check_table(sources, "[sources]", {key: kind for key, kind in kinds.items() if key != "notes"}, kinds)
    for key, names in sources.items():
        for name in names:
            if name not in SOURCES:
                raise ValueError(f"[sources] {key}: {name!r} is not one of {', '.join(map(repr, SOURCES))}")
        if not names:
            raise ValueError(f"[sources] {key} is empty")
    return FrozenDict((key, tuple(names)) for key, names in sources.items())
