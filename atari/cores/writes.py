"""Writes to RAM for the native core, made from the rules of `atari.games.interventions`."""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, asdict, fields
from typing import Any

import atari._emulator as _emulator
from atari.base import json_text
from atari.base.typed_table import check_table
from atari.games.game import Game, RamLabel
from atari.games.interventions import CompiledWrite, Intervention, WriteRule, compile_write
from atari.games.interventions.writes import NO_VALUE, cases

_NEEDED = {"to": str | int, "value": str | int}
_OTHERS = {"when": str | list, "condition": str, "mask": int, "once": bool, "paid": bool}
"""The types of a rule's attributes in JSON."""


def make_write(game: Game, rule: WriteRule, where: str) -> _emulator.Write:
    """The compiled write of a rule; `where` names it in errors.

    Raises:
        TypeError, ValueError: a part of the rule is wrong, or the label cannot have the value; the message says where.
    """
    compiled = compile_write(game, rule, where)
    try:
        write = _emulator.make_write(**asdict(compiled), definition=_definition(rule))
    except ValueError as error:
        raise ValueError(f"{where}: an expression is too large to compile ({error})") from None
    if isinstance(rule.value, int) and isinstance(rule.to, str):
        values = _values(compiled, write, game.ram_labels[rule.to])
        if values and rule.value not in values:
            raise ValueError(f"{where}, value: {rule.to} cannot be {rule.value}; {_possible(values)}")
    return write


def possible_values(game: Game, label: str) -> set[int]:
    """The values that a write can give a label of the game; empty if other bytes of RAM decide that."""
    compiled = compile_write(game, WriteRule(label, "0"), f"the label {label!r}")
    return _values(compiled, _emulator.make_write(**asdict(compiled), definition=""), game.ram_labels[label])


def _values(compiled: CompiledWrite, write: _emulator.Write, label: RamLabel) -> set[int]:
    """The values that the byte of a label gives it, if other bytes only choose the case; else nothing."""
    values = set(write.label_values)
    if not values:
        for program in cases(label):
            of_case = _emulator.make_write(**{**asdict(compiled), "label": program}, definition="").label_values
            if not of_case:
                return set()
            values |= set(of_case)
    return values - {NO_VALUE}


def write_of(game: Game, definition: str) -> _emulator.Write:
    """The write of a `Write.definition`, which may come from a file.

    Raises:
        ValueError: it is no such definition.
    """
    values = check_table(json_text.parse(definition, "a write"), "a write", _NEEDED, _OTHERS)
    when = values.get("when", "frame")
    if isinstance(when, str) and when not in ("frame", "reset", "held"):
        raise ValueError(f"a write cannot be applied at {when!r}")
    if isinstance(when, list) and not all(type(frame) is int for frame in when):
        raise ValueError(f"a write cannot be applied at the frames {when!r:.60}")
    rule = WriteRule(**{**values, "when": tuple(when) if isinstance(when, list) else when})
    return make_write(game, rule, "a write")


def definitions(slots: Sequence[_emulator.Write | None]) -> list[str | None]:
    """The definitions of writes by slot, which can be pickled; None where a write has ended."""
    return [None if write is None else write.definition for write in slots]


def writes_of(game: Game, definitions: Sequence[str | None]) -> list[_emulator.Write | None]:
    """The writes of `definitions`, by slot.

    Raises:
        ValueError: see `write_of`.
    """
    return [None if definition is None else write_of(game, definition) for definition in definitions]


def restore(core: Any, definitions_of_slots: Sequence[str | None]) -> None:
    """Give a core the writes of a result of `definitions`, unless it has them.

    Raises:
        ValueError: see `write_of`.
    """
    if definitions(slots(core)) != definitions_of_slots:
        core.writes = writes_of(core.game, definitions_of_slots)


def first_free(slots: Sequence[_emulator.Write | None]) -> int:
    """The slot that the next write gets."""
    return next((slot for slot, write in enumerate(slots) if write is None), len(slots))


def make_writes(game: Game, interventions: Sequence[Intervention]) -> list[_emulator.Write]:
    """The compiled writes of interventions, in their order.

    Raises:
        TypeError, ValueError: see `make_write`.
    """
    return [
        make_write(game, rule, f"intervention {intervention.name!r}, writes[{number}]")
        for intervention in interventions
        for number, rule in enumerate(intervention.writes)
    ]


def switched_on(interventions: Mapping[str, Intervention], definitions: Iterable[str | None]) -> tuple[str, ...]:
    """The names of the interventions all of whose writes are among these `definitions`."""
    present = set(definitions)
    return tuple(name for name, one in interventions.items() if present.issuperset(map(_definition, one.writes)))


def slots(core: Any) -> list[Any]:
    """The writes of a core by slot; `AleCore` has none."""
    return getattr(core, "writes", [])


def fact(interventions: Sequence[Intervention]) -> str | None:
    """A text that is equal for equal interventions, with their names; None if there are none."""
    if not interventions:
        return None
    text = json.dumps([intervention.definition() for intervention in interventions], sort_keys=True)
    digest = hashlib.blake2b(text.encode(), digest_size=4).hexdigest()
    return f"{', '.join(intervention.name for intervention in interventions)} ({digest})"


def _definition(rule: WriteRule) -> str:
    """The rule as JSON, without the attributes that have their default."""
    rest = {field.name: getattr(rule, field.name) for field in fields(rule)}
    defaults = {field.name: field.default for field in fields(rule) if field.default is not MISSING}
    return json.dumps({name: value for name, value in rest.items() if name not in defaults or defaults[name] != value})


def _possible(values: set[int]) -> str:
    low, high = min(values), max(values)
    if high - low + 1 == len(values):
        return f"its values are {low}..{high}"
    some = sorted(values)
    return f"its values are {', '.join(map(str, some[:20]))}{', ...' if len(some) > 20 else ''} within {low}..{high}"
