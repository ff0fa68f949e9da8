"""The language of game rules: how reward, lives and the end of a game follow from RAM.

A rule is a small expression over the 128 bytes of the console's RAM, written in the syntax of Python and
restricted to integers; `atari/games/SCHEMA.md` documents the grammar. This module parses the `[rules]` table of a
game definition and checks every expression against the grammar; a core evaluates them.
"""

import ast
from collections.abc import Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from atari.base.frozen import FrozenDict
from atari.base.typed_table import check_table, check_type
from atari.games.actions import PLAYER_ACTIONS


class Helper(NamedTuple):
    """A function of the language: the numbers of its arguments, and how many of the first are addresses."""

    fewest: int
    most: int
    addresses: int


HELPERS: Mapping[str, Helper] = {
    "bcd": Helper(1, 8, 8),  # binary-coded decimal digits at these addresses, least significant first
    "s8": Helper(1, 1, 0),  # the low eight bits as a signed number
    "count": Helper(3, 16, 2),  # the number of bytes lo..hi that equal one of the values
    "same": Helper(2, 2, 2),  # whether all bytes lo..hi are equal
    "pos_sum": Helper(2, 2, 2),  # sum of the positive (signed) bytes lo..hi
    "neg_sum": Helper(2, 2, 2),  # sum of the magnitudes of the negative bytes lo..hi
    "rng": Helper(0, 0, 0),  # the next 32-bit word of the environment's generator
}
MEMORIES = ("ram", "xram")
OUTPUTS = ("reward", "lives")
"""The outputs of one player's rules, beside `terminal`. Rules of several players assign `reward_1`, `lives_1`, ..."""
RULE_ADDRESSES = range(0x80, 0x100)
_LONGEST, _DEEPEST = 2000, 100
"""The most characters of an expression, and the most levels of nesting in it."""

LABEL_ADDRESSES = range(128)
"""Addresses of the bytes of RAM: rules use addresses on the console's bus, RAM labels indices into `ram()`."""

ANY_ADDRESSES = range(256)
"""Either of them: rewards and interventions take both, as `atari.lab.Ram` does."""

_OPERATORS = (
    ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp,
    ast.Add, ast.Sub, ast.Mult, ast.FloorDiv, ast.Mod, ast.BitAnd, ast.BitOr, ast.BitXor, ast.LShift, ast.RShift,
    ast.USub, ast.Invert, ast.Not, ast.And, ast.Or,
    ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE,
    ast.Load, ast.Expression,
)  # fmt: skip


@dataclass(frozen=True)
class Operation:
    """One step of selecting a mode at reset, such as pressing SELECT until a byte of RAM equals the mode."""

    op: Literal["set", "press_select", "press_select_until", "soft_reset", "act", "act_until", "repeat_until", "repeat"]
    var: str | None = None
    value: str | None = None
    frames: str | None = None
    until: str | None = None
    max: int | None = None
    action: str | None = None
    times: str | None = None
    do: tuple["Operation", ...] = ()


@dataclass(frozen=True)
class Rules:
    """The expressions for reward, lives and the end of a game from RAM, and the mode selection at a reset.

    `step` holds `(name, expression)` pairs, evaluated from first to last after every emulated frame. The names in
    `state` persist from frame to frame, all others exist for one evaluation. The emulator reads `terminal` and
    `outputs`. If `mode_select` plays until a condition holds, `selection_frames` is the most frames that it may take.
    """

    lives_initial: int
    state: Mapping[str, int]
    step: tuple[tuple[str, str], ...]
    mode_select: tuple[Operation, ...] = ()
    kept_over_reset: tuple[str, ...] = ()
    selection_frames: int = 0
    outputs: tuple[str, ...] = OUTPUTS

    def expression(self, name: str) -> str:
        """The last expression assigned to `name`, for example `expression("reward")`."""
        return next((source for target, source in reversed(self.step) if target == name), name)


_OTHERS: Mapping[str, Any] = {
    "lives_initial": int,
    "mode_select": tuple[dict[str, Any], ...],
    "kept_over_reset": tuple[str, ...],
    "selection_frames": int,
}
_SELECT = "press_select_until"
_OF: Any = Literal
_KEYS: Mapping[str, Any] = {
    "var": str,
    "action": _OF[tuple(action.name for action in PLAYER_ACTIONS)],
    "do": tuple[dict[str, Any], ...],
    **dict.fromkeys(("value", "frames", "until", "times"), Any),
}
"""The types of the keys of mode_select operations."""

_OPERATIONS: Mapping[str, tuple[str, ...]] = {
    "set": ("var", "value"),
    "press_select": ("frames",),
    "press_select_until": ("frames", "until"),
    "soft_reset": (),
    "act": ("action", "times"),
    "act_until": ("action", "until"),
    "repeat_until": ("do", "until"),
    "repeat": ("do", "times"),
}
"""The keys of each operation; `press_select_until` can have `max`, too."""


def parse_rules(table: Mapping[str, Any], outputs: tuple[str, ...] = OUTPUTS) -> Rules:
    """Read and check a `[rules]` table.

    Args:
        table: its content.
        outputs: the names that `step` must assign in addition to `terminal`.

    Raises:
        ValueError: a key is missing or unknown, or an expression is outside the grammar; the message names it.
    """
    needed = {"state": dict, "step": str, **({"lives_initial": int} if outputs == OUTPUTS else {})}
    check_table(table, "[rules]", needed, _OTHERS)
    state = FrozenDict(table["state"])
    for name, value in state.items():
        check_type(value, f"[rules] state: {name}", int)
    numbers = {"lives_initial": table.get("lives_initial", 0), "selection_frames": table.get("selection_frames", 0)}
    step = _parse_step(table["step"], state)
    for name in (*outputs, "terminal"):
        if name not in dict(step):
            raise ValueError(f"[rules] step never assigns {name!r}")
    kept = tuple(table.get("kept_over_reset", ()))
    for name in kept:
        if name not in state:
            raise ValueError(f"[rules] kept_over_reset names {name!r}, which is not in state")
    return Rules(
        **numbers,
        state=state,
        step=step,
        mode_select=_parse_operations(table.get("mode_select", []), {*state, "mode"}),
        kept_over_reset=kept,
        outputs=outputs,
    )


def check_expression(
    source: str,
    names: Iterable[str],
    where: str,
    addresses: range = RULE_ADDRESSES,
    helpers: Mapping[str, Helper] = HELPERS,
) -> ast.Expression:
    """Parse one expression and check it against the grammar.

    Args:
        source: the expression.
        names: the variables in scope.
        where: the expression's place in the file, for error messages.
        addresses: the addresses that `ram[...]` and the helpers accept.
        helpers: the functions of the language.

    Raises:
        ValueError: `source` is not an expression of this language; the message has the place and the fault.
    """
    tree = parse_expression(source, where)
    scope = names if isinstance(names, AbstractSet) else set(names)
    for _, problem in problems(tree, scope, addresses, helpers):
        raise ValueError(f"{where}: in {source!r}, {problem}")
    return tree


def parse_expression(source: str, where: str) -> ast.Expression:
    """Parse one expression, with the bounds of its length and its depth.

    Raises:
        ValueError: `source` is not an expression of Python; the message has the column.
    """
    if not isinstance(source, str) or len(source) > _LONGEST:
        raise ValueError(f"{where}: an expression is a text of at most {_LONGEST:,} characters")
    try:
        tree = ast.parse(source.strip(), mode="eval")
    except SyntaxError as error:
        place = f"in column {error.offset}" if error.offset else "at the end"
        raise ValueError(f"{where}: {source!r} is not an expression: {error.msg} {place}") from None
    except (ValueError, RecursionError, MemoryError) as error:  # a null character; nested too deeply for the parser
        raise ValueError(f"{where}: {source!r} is not an expression: {error or 'it is nested too deeply'}") from None
    if _depth(tree) > _DEEPEST:
        raise ValueError(f"{where}: {source!r} is nested too deeply")
    return tree


def problems(
    tree: ast.AST, scope: AbstractSet[str], addresses: range = RULE_ADDRESSES, helpers: Mapping[str, Helper] = HELPERS
) -> Iterator[tuple[ast.AST, str]]:
    """The nodes of an expression that are outside the grammar, each with its fault."""
    indexed = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Subscript)}
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    for node in ast.walk(tree):
        problem = None if id(node) in indexed | called else _problem(node, scope, addresses, helpers)
        if problem:
            yield node, problem


def check_label_expression(source: str, where: str) -> None:
    """Check an expression of a RAM label: over `v`, the byte, and `ram[0..127]`.

    Raises:
        ValueError: see `check_expression`. A label has neither `xram` nor `rng()`.
    """
    tree = check_expression(source, {"v"}, where, LABEL_ADDRESSES)
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in ("xram", "rng"):
            raise ValueError(f"{where}: in {source!r}, {node.id} cannot be used in a label; use v and ram[0..127]")


def _depth(tree: ast.AST) -> int:
    depth, level = 0, [tree]
    while level := [child for node in level for child in ast.iter_child_nodes(node)]:
        depth += 1
    return depth


def _problem(node: ast.AST, scope: AbstractSet[str], addresses: range, helpers: Mapping[str, Helper]) -> str | None:
    """The fault of one node of an expression, or None."""
    if isinstance(node, ast.Constant):
        good = type(node.value) is int and node.value < 2**31
        return None if good else f"{node.value!r} is not an integer of 32 bits"
    if isinstance(node, ast.Name):
        return None if node.id in scope else f"the name {node.id!r} is not defined before this line"
    if isinstance(node, ast.Subscript):
        if not (isinstance(node.value, ast.Name) and node.value.id in MEMORIES):
            return "only ram[...] and xram[...] can be indexed"
        return _address_problem([node.slice], addresses)
    if isinstance(node, ast.Call):
        if not isinstance(node.func, ast.Name) or node.func.id not in helpers or node.keywords:
            called = ast.unparse(node.func)
            instead = {"min": "; write `a if a < b else b`", "max": "; write `a if a > b else b`"}.get(called, "")
            return f"{called}() is not one of the helpers {', '.join(helpers)}{instead}"
        helper = helpers[node.func.id]
        if not helper.fewest <= len(node.args) <= helper.most:
            return f"{node.func.id}() has {len(node.args)} arguments"
        return _address_problem(node.args[: helper.addresses], addresses)
    return None if isinstance(node, _OPERATORS) else f"{type(node).__name__} is not part of the language"


def _address_problem(nodes: Iterable[ast.AST], addresses: range) -> str | None:
    for node in nodes:
        if not (isinstance(node, ast.Constant) and type(node.value) is int and node.value in addresses):
            return f"an address is a number within {addresses[0]:#x}..{addresses[-1]:#x}, not {ast.unparse(node)}"
    return None


def _parse_step(text: str, state: Mapping[str, int]) -> tuple[tuple[str, str], ...]:
    """Split `name = expression` lines, checking each expression with the names defined before it."""
    lines = []
    scope = set(state)
    for number, line in enumerate(text.strip().splitlines(), 1):
        where = f"[rules] step, line {number}"
        name, equals, source = (part.strip() for part in line.partition("="))
        if not equals or not name.isidentifier():
            raise ValueError(f"{where}: expected 'name = expression', got {line!r}")
        if name in HELPERS or name in MEMORIES:
            raise ValueError(f"{where}: {name!r} has a meaning in the language and cannot be assigned")
        check_expression(source, scope, where)
        scope.add(name)
        lines.append((name, source))
    return tuple(lines)


def _parse_operations(tables: Any, scope: set[str]) -> tuple[Operation, ...]:
    operations = []
    for table in tables:
        keys = dict(table)
        op = check_type(keys.pop("op", None), "[rules] mode_select, op", _OF[tuple(_OPERATIONS)])
        where = f"[rules] mode_select, {op}"
        check_table(keys, where, {key: _KEYS[key] for key in _OPERATIONS[op]}, {"max": int} if op == _SELECT else {})
        for key in ("value", "frames", "until", "times"):
            if key in keys:
                keys[key] = str(keys[key])
                check_expression(keys[key], scope, f"{where} {key}")
        if keys.get("max", 0) < 0:
            raise ValueError(f"{where}: max must be 0 or more, got {keys['max']}")
        if not keys.get("var", "v").isidentifier():
            raise ValueError(f"{where}: var must be the name of a variable, got {keys['var']!r}")
        if "do" in keys:
            keys["do"] = _parse_operations(keys["do"], scope)
        if op == "set":
            scope.add(keys["var"])
        operations.append(Operation(op=op, **keys))
    return tuple(operations)
