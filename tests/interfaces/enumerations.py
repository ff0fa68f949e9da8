"""What can be seen of the members of an enumeration, and how two enumerations differ."""

import ast
import enum
from typing import Any

SEEN = {
    "value": lambda one: one.value,
    "repr": repr,
    "str": str,
    "bool": bool,
    "hash": lambda one: hash(one) == hash(one.name),
    "equals its value": lambda one: one == one.value,
    "by value": lambda one: type(one)(one.value) is one,
    "is a number": lambda one: isinstance(one, int),
}
"""What can be seen of a member of an enumeration."""


def describe(kind: Any) -> str:
    """What can be seen of an enumeration: its members in the order of iteration, each with `SEEN`."""
    if not issubclass(kind, enum.Enum):
        return repr([*kind.__members__])
    return repr({one.name: {name: _outcome(look, one) for name, look in SEEN.items()} for one in kind})


def _outcome(look: Any, one: Any) -> Any:
    try:
        return look(one)
    except Exception as error:
        return type(error).__name__


def compare_enumeration(text: str, kind: Any) -> str | None:
    """How an enumeration differs from one that `describe` has described; None if it does not."""
    if not hasattr(kind, "__members__"):
        return "no enumeration"
    theirs, ours = ast.literal_eval(text), ast.literal_eval(describe(kind))
    if [*theirs] != [*ours]:
        return f"the members {', '.join(ours)}, not {', '.join(theirs)}"
    for member in theirs if isinstance(theirs, dict) else ():
        for name, seen in theirs[member].items():
            if ours[member][name] != seen:
                return f"{name} of {member} is {ours[member][name]!r}, not {seen!r}"
    return None
