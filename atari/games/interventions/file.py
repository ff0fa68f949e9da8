"""`load` and `resolve` read files of interventions, `data/<game>.toml` and users' own; docs/ram.md has the format."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from atari.base.frozen import FrozenDict
from atari.base.typed_table import check_table
from atari.base.validation import check_integer
from atari.games.actions import Action
from atari.games.catalog import games
from atari.games.game import Game
from atari.games.interventions.writes import (
    LATEST_FRAME,
    WriteRule,
    compile_write,
    find_label,
    parse_expression,
    unknown,
)
from atari.games.toml_file import read_toml

_FOLDER = Path(__file__).parent / "data"
_MOST_WRITES = 64
_MOST_FRAMES = 100_000
CHECK_NAMES = ("reward", "lives", "frame", "pixels")
"""The names in a check's expressions besides labels; a label of the same name takes precedence."""


@dataclass(frozen=True)
class Check:
    """The proof of an intervention's effect: the frames to play, and the expression that must hold.

    Attributes:
        frames: number of emulated frames to play.
        actions: "random", "noop", or names of actions, which are repeated.
        kind: "holds", "more" or "less".
        expression: over labels, `ram[...]`, `CHECK_NAMES`, and the calls `first(label)` and `changes(label)`.
        after: frames at the start that do not count.
        by: the factor for "more" and "less".
    """

    frames: int
    actions: Literal["random", "noop"] | tuple[str, ...]
    kind: Literal["holds", "more", "less"]
    expression: str
    after: int = 0
    by: float = 1.2


@dataclass(frozen=True)
class Intervention:
    """A described change of a game. `table` is its definition in a file's form, without the name."""

    name: str
    description: str
    source: str
    writes: tuple[WriteRule, ...]
    check: Check | None
    table: Mapping[str, Any]

    def definition(self) -> dict[str, Any]:
        """The definition with the name under "name": plain data, which the option `interventions` accepts."""
        return {"name": self.name, **_thawed(self.table)}


def load(game: "str | Game", file: str | PathLike[str] | None = None) -> Mapping[str, Intervention]:
    """The interventions of a game by name, in alphabetical order; empty if the package has none.

    An `Intervention` has `name`, `description`, `source`, `writes`, `check` and `definition()`, which is plain data
    that the option `interventions` accepts.

    Args:
        game: a game or its name.
        file: a file of interventions for the game, instead of the package's.

    Raises:
        ValueError: there is no such game, or the file is not valid; the message names file, intervention and key.
        OSError: the file cannot be read.

    Example:
        >>> from pathlib import Path
        >>> from atari.lab.interventions import load
        >>> load("pong")["lazy_enemy"].description
        "The opponent's paddle stands still."
        >>> rule = '{description = "The ball stands still.", source = "own", writes = [{to = "ball_x", value = "old"}]}'
        >>> _ = Path("own.toml").write_text(f"still_ball = {rule}")
        >>> load("pong", "own.toml")["still_ball"].description
        'The ball stands still.'
    """
    found = games.resolve(game)
    path = _FOLDER / f"{found.id}.toml" if file is None else Path(file)
    if file is None and not path.exists():
        return FrozenDict()
    if not path.exists():
        nearest = unknown(path.name, "file", (file.name for file in path.parent.glob("*.toml")), str(path.parent))
        raise FileNotFoundError(f"there is no file of interventions {path}; {nearest}")
    return _load(path, found, path.stat().st_mtime_ns)


def resolve(game: Game, items: Any) -> tuple[Intervention, ...]:
    """The interventions that the option `interventions` names.

    Args:
        game: the game.
        items: a list; each item is a name, a path "file.toml#name", an `Intervention` or its `definition()`.

    Raises:
        TypeError: `items` is no list of these.
        ValueError: there is no such intervention (the message suggests the nearest), or a definition is wrong.
        FileNotFoundError: there is no such file; the message suggests the nearest.
        OSError: a file cannot be read.
    """
    if items is None:
        return ()
    if isinstance(items, (str, Mapping, Intervention)) or not isinstance(items, Sequence):
        raise TypeError(f"interventions must be a list of names such as ['lazy_enemy'], got {items!r}")
    found = tuple(_resolve(game, item) for item in items)
    writes = sum(len(one.writes) for one in found)
    if writes > _MOST_WRITES:
        raise ValueError(f"interventions may have {_MOST_WRITES} writes together, these have {writes}")
    return found


def from_definition(game: Game, definition: Mapping[str, Any]) -> Intervention:
    """An intervention from its `definition()`.

    Raises:
        ValueError: the definition is wrong.
    """
    table = dict(definition)
    name = table.pop("name", None)
    if not isinstance(name, str):
        raise ValueError(f"an intervention's definition needs its name under 'name', got {name!r}")
    return _parse(name, table, game, f"intervention {name!r}")


def _resolve(game: Game, item: Any) -> Intervention:
    if isinstance(item, Intervention):
        return from_definition(game, item.definition())
    if isinstance(item, Mapping):
        return from_definition(game, item)
    if not isinstance(item, str):
        raise TypeError(f"an intervention is a name such as 'lazy_enemy', or 'file.toml#name', got {item!r}")
    path, separator, name = item.rpartition("#")
    known = load(game, path if separator else None)
    if name not in known:
        if name.endswith(".toml"):
            raise ValueError(f"{name} is a file: name the intervention too, {name}#name")
        raise ValueError(unknown(name, "intervention", known, path or game.id))
    return known[name]


@lru_cache(maxsize=256)
def _load(path: Path, game: Game, changed: int) -> Mapping[str, Intervention]:
    tables = read_toml(path, "a file of interventions")
    found = {name: _parse(name, table, game, f"{path}, [{name}]") for name, table in sorted(tables.items())}
    return FrozenDict(found)


def _parse(name: str, table: Any, game: Game, where: str) -> Intervention:
    needed = {"description": str, "source": str, "writes": tuple[dict[str, Any], ...]}
    check_table(table, where, needed, {"check": dict, "paid": bool})
    for key in ("description", "source"):
        if not table[key]:
            raise ValueError(f"{where}, {key}: must be a text, got ''")
    writes = table["writes"]
    if not 1 <= len(writes) <= _MOST_WRITES:
        raise ValueError(f"{where}, writes: must be a list of 1..{_MOST_WRITES} tables, got {writes!r}")
    rules = []
    for number, write in enumerate(writes):
        place = f"{where}, writes[{number}]"
        rules.append(_write(write, table.get("paid", True), place))
        try:
            compile_write(game, rules[-1], place)
        except TypeError as error:
            raise ValueError(str(error)) from None
    check = _check(table["check"], game, f"{where}, check") if "check" in table else None
    return Intervention(name, table["description"], table["source"], tuple(rules), check, _frozen(table))


def _write(table: Any, paid: bool, where: str) -> WriteRule:
    check_table(table, where, {"to": str | int, "value": str | int}, {"when": Any, "if": str | None, "mask": Any})
    when = _when(table.get("when", "frame"), f"{where}, when")
    return WriteRule(table["to"], table["value"], when, table.get("if"), table.get("mask", 0xFF), paid=paid)


def _when(value: Any, where: str) -> "Literal['frame', 'reset'] | tuple[int, ...]":
    if value in ("frame", "reset"):
        return value
    frames = list(value) if isinstance(value, (list, tuple)) else [value]
    if not frames or not all(type(frame) is int and 0 <= frame <= LATEST_FRAME for frame in frames):
        raise ValueError(f"{where}: must be 'frame', 'reset', a frame of the episode or a list of these, got {value!r}")
    return tuple(frames)


def _check(table: Any, game: Game, where: str) -> Check:
    expressions = dict.fromkeys(("holds", "more", "less"), str | int)
    check_table(table, where, {"frames": int}, {"actions": Any, **expressions, "after": int, "by": float})
    kinds = [kind for kind in ("holds", "more", "less") if kind in table]
    if len(kinds) != 1:
        raise ValueError(f"{where}: needs one of 'holds', 'more' and 'less', got {', '.join(kinds) or 'none'}")
    kind: Any = kinds[0]
    expression = table[kind]
    frames = check_integer(f"{where}, frames", table["frames"], 1, _MOST_FRAMES)
    by = table.get("by", 1.2)
    if not 1.0 <= by <= 1e6:
        raise ValueError(f"{where}, by: must be a factor of 1 or more, got {by!r}")
    if "by" in table and kind == "holds":
        raise ValueError(f"{where}, by: is the factor of 'more' and 'less', and not of 'holds'")
    source, calls = split_calls(str(expression), game, f"{where}, {kind}")
    parse_expression(game, source, (*CHECK_NAMES, *calls), f"{where}, {kind}")
    return Check(
        frames=frames,
        actions=_actions(table.get("actions", "random"), game, f"{where}, actions"),
        kind=kind,
        expression=str(expression),
        after=check_integer(f"{where}, after", table.get("after", 0), 0, frames - 1),
        by=float(by),
    )


def split_calls(source: str, game: Game, where: str) -> tuple[str, dict[str, tuple[str, str]]]:
    """An expression with its calls `first(label)` and `changes(label)` replaced by names, and the calls by these names.

    Raises:
        ValueError: there is no such label.
    """
    calls: dict[str, tuple[str, str]] = {}

    def name(match: "re.Match[str]") -> str:
        function, label = match.groups()
        find_label(game, label, where)
        calls[f"{function}__{label}"] = (function, label)
        return f"{function}__{label}"

    return re.sub(r"\b(first|changes)\(\s*(\w+)\s*\)", name, source), calls


def _actions(value: Any, game: Game, where: str) -> Any:
    if value in ("random", "noop"):
        return value
    legal = [action.name for action in game.legal_actions]
    names = list(value) if isinstance(value, (list, tuple)) else []
    if not names or not all(isinstance(one, str) and one in legal and one in Action.__members__ for one in names):
        raise ValueError(f"{where}: must be 'random', 'noop' or a list of legal actions such as 'FIRE', got {value!r}")
    return tuple(names)


def _frozen(value: Any) -> Any:
    if isinstance(value, Mapping):
        return FrozenDict((key, _frozen(item)) for key, item in value.items())
    return tuple(map(_frozen, value)) if isinstance(value, (list, tuple)) else value


def _thawed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _thawed(item) for key, item in value.items()}
    return list(map(_thawed, value)) if isinstance(value, tuple) else value
