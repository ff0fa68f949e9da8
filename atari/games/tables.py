"""Reads the tables of a game definition: it checks keys, types and numbers, and its errors name the place."""

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, fields
from types import UnionType
from typing import Any, Literal, TypeVar, get_args, get_origin

from atari.games.actions import PLAYER_ACTIONS, Action, Switch

T = TypeVar("T")


def build(kind: type[T], table: Mapping[str, Any], where: str) -> T:
    """An instance of a dataclass from a table whose keys are its fields, after checking keys and types."""
    required = [field.name for field in fields(kind) if field.default is MISSING]  # type: ignore[arg-type]
    optional = [field.name for field in fields(kind) if field.default is not MISSING]  # type: ignore[arg-type]
    check_keys(table, where, required, optional)
    for field in fields(kind):  # type: ignore[arg-type]
        if field.name in table:
            check_value(f"{where} {field.name}", table[field.name], field.type)
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in table.items()})


def check_numbers(value: Any, where: str) -> None:
    """Check that all numbers in a value fit in the emulator's 32 bits."""
    if isinstance(value, int) and not -(2**31) <= value < 2**31:
        raise ValueError(f"{where} is not an integer of 32 bits")
    for key, item in value.items() if isinstance(value, Mapping) else enumerate(value) if type(value) is list else ():
        check_numbers(item, f"{where}.{key}" if where else str(key))


def check_keys(table: Mapping[str, Any], where: str, required: Iterable[str], optional: Iterable[str] = ()) -> None:
    """Check that a value is a table with the required keys, and no other keys except the optional ones."""
    if not isinstance(table, Mapping):
        raise ValueError(f"{where} must be a table, got {table!r}")
    allowed = (*required, *optional)
    for key in table:
        if key not in allowed:
            raise ValueError(f"{where} has no key {key!r} (expected {', '.join(allowed)})")
    for key in required:
        if key not in table:
            raise ValueError(f"{where} needs the key {key!r}")


def check_value(where: str, value: Any, kind: Any) -> None:
    """Check that a TOML value has the annotated type of a field."""
    if not _fits(value, kind):
        # In Python 3.10, `tuple[int, ...]` is an instance of `type`.
        text = kind.__name__ if isinstance(kind, type) and not get_origin(kind) else str(kind).replace("typing.", "")
        raise ValueError(f"{where} must be {text}, got {value!r}")


def _fits(value: Any, kind: Any) -> bool:
    """Whether a TOML value has the annotated type of a field."""
    if get_origin(kind) is Literal:
        return value in get_args(kind)
    if isinstance(kind, UnionType):
        return any(_fits(value, option) for option in get_args(kind))
    if get_origin(kind) is tuple:
        kinds = get_args(kind) if get_args(kind)[-1] is not ... else get_args(kind)[:1] * len(value)
        return isinstance(value, list) and len(value) == len(kinds) and all(map(_fits, value, kinds))
    return type(value) is kind


def actions(names: "Literal['all'] | list[str]") -> tuple[Action, ...]:
    """The actions with these names; "all" means all eighteen."""
    if names != "all" and isinstance(names, list) and not _SWITCHES.keys().isdisjoint(map(str, names)):
        raise ValueError(f"[actions] {', '.join(_SWITCHES)} can only be in starting")
    return tuple(Action(action) for action in starting_actions(names))


def starting_actions(names: "Literal['all'] | list[str]") -> tuple[Action | Switch, ...]:
    """The actions with these names, and the switches of the console."""
    if names == "all":
        return PLAYER_ACTIONS
    check_value("[actions] a list of actions", names, tuple[str, ...])
    known: dict[str, Action | Switch] = {**Action.__members__, **_SWITCHES}
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"[actions] unknown action {unknown[0]!r}")
    return tuple(known[name] for name in names)


_SWITCHES = dict(Switch.__members__)
