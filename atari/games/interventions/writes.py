"""`WriteRule`: one write to RAM, and `compile_write`, which compiles it to programs of the native core.

A rule's expressions have the syntax of `atari.games.rules`, over the values of labels, `ram[...]`, `old` and `frame`,
with the helper `random`. A label in an expression is replaced by the expression of its value.
"""

import ast
import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, cast

from atari.base.validation import check_integer
from atari.games.compiler import compile_expression
from atari.games.game import Game, RamLabel
from atari.games.labels import over_ram, value_source
from atari.games.rules import ANY_ADDRESSES, HELPERS, LABEL_ADDRESSES, Helper, check_expression

_HELPERS = {**HELPERS, "random": Helper(2, 2, 0)}
_FEW = 12
"""The most names that an error lists beside the nearest."""

_VARIABLES = {"old": 1, "frame": 2, "v": 3}
"""The numbers of a write's variables, as in `WriteVariable` of `atari/emulator/ale/programs/writes.hpp`."""

_RESULT = 0
LATEST_FRAME = 2**31 - 1
NO_VALUE = -(2**31) + 1
"""The value that a write reads from a decimal byte with a digit above 9. No write stores such a byte."""


@dataclass(frozen=True)
class WriteRule:
    """One write.

    Attributes:
        to: a label, whose value is written, or a place in RAM: an index 0..127, or an address 0x80..0xFF.
        value: a number or an expression.
        when: "frame" is after every emulated frame, "reset" after the reset, integers are frames of the episode.
            "held" is both "frame" and "reset".
        condition: an expression, or None.
        mask: the bits that are written to a place.
        once: whether the write is applied only once, instead of in each episode.
        paid: whether the rules may reward the change.
    """

    to: str | int
    value: int | str
    when: Literal["frame", "reset", "held"] | tuple[int, ...] = "frame"
    condition: str | None = None
    mask: int = 0xFF
    once: bool = False
    paid: bool = True


@dataclass(frozen=True)
class CompiledWrite:
    """The arguments of `_emulator.make_write`."""

    index: int
    mask: int
    every_frame: bool
    at_reset: bool
    frames: list[int]
    once: bool
    paid: bool
    remembers: bool
    condition: list[int]
    value: list[int]
    label: list[int]


def compile_write(game: Game, rule: WriteRule, where: str) -> CompiledWrite:
    """Check a rule and compile it; `where` names it in errors.

    Raises:
        TypeError, ValueError: a label, a place, a mask, a frame or an expression is wrong; the message has the place.
    """
    label = find_label(game, rule.to, f"{where}, to") if isinstance(rule.to, str) else None
    if label is None:
        index = check_integer(f"{where}, to", rule.to, 0, 255) % 128
        mask = check_integer(f"{where}, mask", rule.mask, 1, 255)
        if isinstance(rule.value, int):
            check_integer(f"{where}, value", rule.value, 0, 255)
    else:
        index, mask = label.index, 0xFF if label.mask is None else label.mask
        if rule.mask != 0xFF:
            raise ValueError(
                f"{where}, mask: the label {label.name!r} has its own; write to place {label.index} instead"
            )
    sources = [(str(rule.value), "value"), *([] if rule.condition is None else [(rule.condition, "if")])]
    trees = [parse_expression(game, source, ("old", "frame"), f"{where}, {key}") for source, key in sources]
    programs = [compile_expression(tree, _VARIABLES, _RESULT) for tree in trees]
    frames = rule.when if isinstance(rule.when, tuple) else ()
    return CompiledWrite(
        index=index,
        mask=mask,
        every_frame=rule.when in ("frame", "held"),
        at_reset=rule.when in ("reset", "held") or 0 in frames,
        frames=[check_integer(f"{where}, when", frame, 0, LATEST_FRAME) for frame in frames if frame != 0],
        once=rule.once,
        paid=rule.paid,
        remembers=any(isinstance(node, ast.Name) and node.id == "old" for tree in trees for node in ast.walk(tree)),
        condition=programs[1] if rule.condition is not None else [],
        value=programs[0],
        label=[] if label is None else compile_expression(_parse_label(label), _VARIABLES, _RESULT),
    )


def find_label(game: Game, name: str, where: str) -> RamLabel:
    """The label of a name.

    Raises:
        ValueError: the game has no such label; the message suggests the nearest.
    """
    if name not in game.ram_labels:
        raise ValueError(f"{where}: {unknown(name, 'label', game.ram_labels, game.id)}")
    return game.ram_labels[name]


def unknown(name: Any, kind: str, names: Iterable[str], game: str) -> str:
    """The error message for a name that does not exist, with the nearest known name."""
    names = tuple(names)
    near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.4)
    hint = f"it has {', '.join(names) or 'none'}"
    if near:
        hint = f"did you mean {near[0]!r}?" + (f" It {hint[3:]}" if len(names) <= _FEW else "")
    return f"{game} has no {kind} {name!r}; {hint}"


def parse_expression(game: Game, source: str, names: Iterable[str], where: str) -> ast.Expression:
    """Parse an expression over `names` and the labels of a game, and replace the labels by their values.

    Raises:
        ValueError: `source` is not such an expression; the message has the place and the fault.
    """
    names = set(names)
    tree = check_expression(source, _AnyName(), where, ANY_ADDRESSES, _HELPERS)
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    called |= {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Subscript)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and id(node) not in called and node.id not in names | set(game.ram_labels):
            raise ValueError(
                f"{where}: in {source!r}, {unknown(node.id, 'label', [*game.ram_labels, *names], game.id)}"
            )
    return cast(ast.Expression, _LabelValues(game, names).visit(tree))


class _AnyName(set[str]):
    """A scope with all names; a later check refuses unknown ones."""

    def __contains__(self, name: object) -> bool:
        return True


class _LabelValues(ast.NodeTransformer):
    """Replaces the names of labels by the expressions of their values, except `names`."""

    def __init__(self, game: Game, names: set[str]) -> None:
        self._game, self._names = game, names

    def visit_Call(self, node: ast.Call) -> ast.AST:
        node.args = [self.visit(argument) for argument in node.args]
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        return node

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id in self._names:
            return node
        label = self._game.ram_labels[node.id]
        return over_ram(value_source(label), label.index)


def cases(label: RamLabel) -> list[list[int]]:
    """The programs of a label's value by its cases, without numbers that another byte of RAM chooses.

    No write of the label's byte gives it such a number, as 0 in "0 if ram[24] == 5 else v + 1".
    """
    programs = []
    rest = [_parse_label(label).body]
    while rest:
        match rest.pop():
            case ast.IfExp(test=test, body=body, orelse=orelse):
                chosen = any(isinstance(node, ast.Subscript) for node in ast.walk(test))
                rest += [case for case in (body, orelse) if not (chosen and isinstance(case, ast.Constant))]
            case value:
                programs.append(compile_expression(ast.Expression(value), _VARIABLES, _RESULT))
    return programs


def _parse_label(label: RamLabel) -> ast.Expression:
    source = value_source(label)
    if label.transform is None and label.encoding == "bcd":
        source = f"{source} if (v & 15) < 10 and (v & 240) < 160 else {NO_VALUE}"
    return check_expression(source, {"v"}, label.name, LABEL_ADDRESSES)
