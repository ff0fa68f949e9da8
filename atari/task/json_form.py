"""A `Task` as JSON: strict, with a version, and bounded in size and depth."""

import json
from collections.abc import Collection, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from atari.base import json_text
from atari.base.typed_table import check_table, check_type
from atari.cores.writes import fact
from atari.games.catalog import games
from atari.games.game import Game
from atari.task.data import TaskData
from atari.task.fields import DEFAULTS, FIELDS

_Kind = TypeVar("_Kind", bound=TaskData)

FORMAT = 1
"""The version of the format. A newer version is an error; for an older one, `_DEFAULTS` fills in the missing keys."""

_DEFAULTS: Mapping[int, Mapping[str, Any]] = {1: {**DEFAULTS, "file": None}}
"""The values of missing keys, by version of the format."""


def to_json(task: TaskData) -> str:
    """All fields of a task, sorted by name, with the path of its game file.

    Raises:
        ValueError: the game is a `Game` without a file.
    """
    game = task.definition
    if game.file is None and games.get(game.id) != game:  # a pickled game is equal, but another object
        raise ValueError(f"the game {game.id!r} was made in memory; write its definition to a .toml file and use that")
    file = None if game.file is None else str(game.file)
    return json.dumps({"format": FORMAT, **_table(task), "file": file}, sort_keys=True)


def to_short_json(task: TaskData) -> str:
    """The fields of a task that do not have their default, for a file that names the game elsewhere."""
    defaults = {**_DEFAULTS[FORMAT], "interventions": []}
    changed = {name: value for name, value in _table(task).items() if name == "game" or value != defaults[name]}
    return json.dumps({"format": FORMAT, **changed}, sort_keys=True)


@lru_cache(maxsize=256)
def identity(task: TaskData) -> str:
    """The text of a task in a snapshot: `to_short_json` without the ROM, which the snapshot of the core has."""
    return to_short_json(task.with_checked(rom_md5=None))


def require_same(stored: Any, own: TaskData, ignored: Collection[str] = ()) -> None:
    """Check that the task of a snapshot plays like another task.

    Args:
        stored: the text of `identity` in the snapshot.
        own: the task into which the snapshot is to be restored.
        ignored: fields that may differ.

    Raises:
        ValueError: fields differ (the message names all), or `stored` is no task.
    """
    if stored == identity(own):
        return
    if not isinstance(stored, str):
        raise ValueError(f"the snapshot is damaged: its task is {stored!r:.80}")
    game = _read(stored).get("game")
    pairs = (
        {"game": (game, own.game)} if game != own.game else from_json(TaskData, stored, own.definition).differences(own)
    )
    kept = {name: pair for name, pair in pairs.items() if name not in ignored}
    texts = [[f"{name} = {_shown(name, one)}", _shown(name, other)] for name, (one, other) in kept.items()]
    if texts:
        differing = "; ".join([", but this environment has ".join(texts[0]), *map(", not ".join, texts[1:])])
        raise ValueError(f"the snapshot was taken with {differing}; restore it into one made with the same options")


def _shown(name: str, value: Any) -> str:
    return repr(fact(value) if name == "interventions" else value)[:200]


def _table(task: TaskData) -> dict[str, Any]:
    fields = {name: getattr(task, name) for name in FIELDS}
    return {**fields, "interventions": [one.definition() for one in task.interventions]}


def from_json(kind: type[_Kind], text: str, game: Game | None = None) -> _Kind:
    """The task of a text of `to_json`, of a class; see `Task.from_json`."""
    table = _read(text)
    number = table.pop("format", None)
    if isinstance(number, bool) or not isinstance(number, int) or number < 1:
        raise ValueError(f'a task\'s "format" must be an integer of 1 or more, got {number!r}')
    if number > FORMAT:
        raise ValueError(
            f"the task is of format {number}, and this release of atari-envs reads up to {FORMAT}; install a newer one"
        )
    defaults = _DEFAULTS[number]
    kinds = {**dict.fromkeys(defaults, Any), "interventions": tuple[dict[str, Any], ...], "file": str | None}
    fields = {**defaults, **check_table(table, "a task", {"game": str}, kinds)}
    fields["game"] = _game(fields["game"], fields.pop("file"), game)
    try:
        return kind(**fields)
    except TypeError as error:
        raise ValueError(str(error)) from None


def _game(name: Any, file: Any, game: Game | None) -> Any:
    """The game of a stored task, in a form that `Task` takes."""
    if game is not None:
        if name != game.id or file is not None:
            raise ValueError(f"the task is of the game {file or name!r}, not of {game.id!r}")
        return game
    if file is None:
        if name not in games:
            raise ValueError(games.unknown(name))
        return games[name]
    if Path(file).suffix != ".toml":
        raise ValueError(f"'file' must be a game file, *.toml, got {file!r}")
    if not Path(file).is_file():
        raise ValueError(f"the game file {file} of the task is gone; put it there again, or use the game's name")
    return Path(file)


def _read(text: Any) -> dict[str, Any]:
    if not isinstance(text, str):
        raise TypeError(f"a task is read from a string of JSON, got {text!r:.80}")
    return check_type(json_text.parse(text, "the task"), "a task", dict)
