"""Checks tables from files, and options, against declared types: the keys, and the types of the values.

A type is an annotation: int, str, bool, float, None, list, dict, Any, a union of types, a `Literal`, `tuple[int, ...]`
or `tuple[int, int]`. A bool is no int; an int is a float, too; a list is a tuple.
"""

import difflib
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import MISSING, fields
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

T = TypeVar("T")
Types = Mapping[str, Any]
"""The type of each key."""


def check_table(value: Any, where: str, required: Types, optional: Types | None = None) -> dict[str, Any]:
    """The content of a table whose keys and types of values are as declared.

    Args:
        value: the table.
        where: its place, which begins the errors.
        required: the keys that it must have, with the types of their values.
        optional: the keys that it may have.

    Raises:
        ValueError: it is no table; a key is missing or unknown (the nearest is suggested); a value is of another type.
    """
    kinds = {**required, **(optional or {}), **required}
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} must be a table, got {value!r:.60}")
    for key in value:
        if key not in kinds:
            near = difflib.get_close_matches(str(key), kinds, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise ValueError(f"{where} has no key {key!r:.60}; {hint}it can have {', '.join(kinds) or 'none'}")
    for key in required:
        if key not in value:
            raise ValueError(f"{where} needs the key {key!r}")
    return {key: check_type(one, f"{where}: {key!r}", kinds[key]) for key, one in value.items()}


def check_type(value: Any, where: str, kind: Any) -> Any:
    """`value`, if it is of a type.

    Raises:
        ValueError: it is of another type.
    """
    if not fits(value, kind):
        raise ValueError(f"{where} must be {in_words(kind)}, got {value!r:.60}")
    return value


def build(kind: type[T], table: Any, where: str) -> T:
    """An instance of a dataclass from a table whose keys are its fields.

    Raises:
        ValueError: see `check_table`.
    """
    kinds, own = get_type_hints(kind), fields(kind)  # type: ignore[arg-type]
    required = {one.name: kinds[one.name] for one in own if one.default is MISSING}
    checked = check_table(table, where, required, {one.name: kinds[one.name] for one in own})
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in checked.items()})


def members(kind: Any) -> tuple[Any, ...]:
    """The types of a union; otherwise the type alone."""
    return get_args(kind) if get_origin(kind) in (UnionType, Union) else (kind,)


def fits(value: Any, kind: Any) -> bool:
    """Whether a value is of a type."""
    if len(members(kind)) > 1:
        return any(fits(value, one) for one in members(kind))
    if get_origin(kind) is Literal:
        return any(value == one and type(value) is type(one) for one in get_args(kind))  # 1 == True
    if get_origin(kind) is tuple:
        if not isinstance(value, (list, tuple)):
            return False
        kinds = get_args(kind) if get_args(kind)[-1] is not ... else get_args(kind)[:1] * len(value)
        return len(value) == len(kinds) and all(map(fits, value, kinds))
    if kind in (int, float) and isinstance(value, bool):
        return False
    kind = get_origin(kind) or kind
    return isinstance(value, _CLASSES.get(kind, kind))


_CLASSES: Mapping[Any, Any] = {
    Any: object,
    None: NoneType,
    float: (int, float),
    dict: Mapping,
    list: (list, tuple),
}
"""The classes of the values of a type, if they are others than the type itself."""

_WORDS = {
    int: "a whole number", float: "a number", bool: "true or false", str: "a text", list: "a list", dict: "a table",
    NoneType: "none", None: "none",
}  # fmt: skip


def in_words(kind: Any) -> str:
    """A type in words, for errors."""
    if len(members(kind)) > 1:
        return " or ".join(map(in_words, members(kind)))
    if get_origin(kind) is Literal:
        return f"one of {', '.join(map(in_text, get_args(kind)))}"
    if get_origin(kind) is tuple:
        first, *others = get_args(kind)
        count = "a list of" if ... in others else f"a list of {1 + len(others)}"
        return f"{count} {in_words(first).removeprefix('a ')}s"
    return _WORDS.get(get_origin(kind) or kind) or str(getattr(kind, "__name__", kind))


def in_text(value: Any) -> str:
    """A value as `from_text` reads it."""
    if isinstance(value, bool) or value is None:
        return str(value).lower()
    return ",".join(map(in_text, value)) if isinstance(value, (list, tuple)) else str(value)


def from_text(text: str, kind: Any) -> Any:
    """The value of a text on a command line: a number, a word, true, false or none, or several with commas between.

    A text that is no value of the type is returned unchanged; the check of the value refuses it.

    Example:
        >>> from atari.base.typed_table import from_text
        >>> from_text("1e6", int), from_text("2,5", int | tuple[int, int]), from_text("none", str | None)
        (1000000, (2, 5), None)
    """
    kinds = list(members(kind))
    of_several = [get_args(one)[0] for one in kinds if get_origin(one) is tuple]
    if of_several and "," in text:
        return tuple(from_text(word, of_several[0]) for word in text.split(","))
    for one in kinds:
        named = get_args(one) if get_origin(one) is Literal else {bool: (True, False), NoneType: (None,)}.get(one, ())
        for value in named:
            if in_text(value) == text:
                return value
    numbers = [one for one in (*kinds, *of_several) if one in (int, float)]
    return _number(text, numbers[0]) if numbers else text


def _number(text: str, kind: type[int] | type[float]) -> Any:
    """A text as a number, if it is one; 1e6 is a whole number, too."""
    with suppress(ValueError):
        return kind(text)
    with suppress(ValueError):
        number = float(text)
        return int(number) if number.is_integer() else number
    return text
