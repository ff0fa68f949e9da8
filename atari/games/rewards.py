"""The reward of a task as an expression: the language of game rules, on float64, over a step and the state before it.

docs/rewards.md describes the language. `compile_reward` makes the program that `RewardFormula` of
`atari/emulator/ale/programs/reward.hpp` evaluates after each step of an agent.
"""

import ast
import difflib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NoReturn

from atari.games.compiler import BINARY, COMPARE, UNARY, compile_expressions
from atari.games.game import Game
from atari.games.labels import over_ram, value_source
from atari.games.rules import ANY_ADDRESSES, HELPERS, MEMORIES, parse_expression, problems

OWN_NAMES = ("reward", "lives", "lives_lost")
"""The names that every game has, in the order of the first inputs of `RewardFormula`."""

BEFORE = "before"
MOST = 3.4028234663852886e38
"""The largest number of float32, which limits all numbers."""

MOST_TERMS = 64
"""The most numbers that a reward reads from RAM: `kMaxVariables` of the emulator's programs."""

_FORMULA = (
    "load add subtract multiply divide floor_divide modulo and or xor shift_left shift_right "
    "equal not_equal less less_equal greater greater_equal minimum maximum both either "
    "negate invert not absolute choose"
).split()
"""Names of the operations; an operation's index is its number in `FormulaOp`."""

_BINARY: Mapping[type[ast.operator], str] = {**BINARY, ast.Div: "divide", ast.FloorDiv: "floor_divide"}
_FUNCTIONS: Mapping[str, tuple[str, int, int]] = {
    "abs": ("absolute", 1, 1),
    "min": ("minimum", 2, 8),
    "max": ("maximum", 2, 8),
}
"""The functions of numbers: the operation, and the fewest and the most arguments."""

_OF_RAM = tuple(name for name in HELPERS if name != "rng")
_CALLS = (*_FUNCTIONS, "visible", *_OF_RAM)
_SYNTAX = (
    "numbers, names, before.name, + - * / // % & | ^ ~ << >>, comparisons, and, or, not, 'a if b else c', "
    "ram[0x80..0xff], "
    f"{', '.join(f'{name}()' for name in _CALLS)}"
)


@dataclass(frozen=True)
class CompiledReward:
    """A reward for the native core: the arguments of `_emulator.RewardFormula`."""

    terms: list[int]
    visibility: list[int]
    words: list[int]
    constants: list[float]


def as_one_line(text: str) -> str:
    """The text of an expression with single spaces, as tasks store it."""
    return " ".join(text.split())


def compile_reward(game: Game, text: str) -> CompiledReward:
    """Check and compile the reward of a task.

    Args:
        game: the game, whose labels the expression names.
        text: the expression, in one line.

    Raises:
        ValueError: the text is outside the language; the message has the column, what stands there and what is
            accepted.

    Example:
        >>> import atari
        >>> from atari.games.rewards import compile_reward
        >>> compile_reward(atari.games["pong"], "reward + 0.5 * lives_lost").constants
        [0.5]
    """
    return _Compiler(game, text).compiled()


class _Compiler:
    """Compiles one expression. Terms are collected by their source; numbers and inputs become variables at the end."""

    def __init__(self, game: Game, text: str) -> None:
        self._game = game
        self._text = text
        self._tree = parse_expression(text, "reward")
        self._terms: dict[str, ast.expr] = {}
        self._visibility: dict[str, str] = {}  # by the name of a term, the term with its visibility
        self._constants: dict[float, None] = {}
        self._code: list[tuple[str, tuple[str, object] | None]] = []

    def compiled(self) -> CompiledReward:
        if "#" in self._text:
            column = self._text.index("#") + 1
            raise ValueError(f"reward: in {self._text!r}, column {column}, at '#': an expression has no comments")
        self._node(self._tree.body)
        terms = list(self._terms)
        if len(terms) > MOST_TERMS:
            raise ValueError(f"reward: {self._text!r} reads {len(terms)} numbers of RAM, and at most {MOST_TERMS} fit")
        inputs = [*OWN_NAMES, *terms]
        numbers: dict[tuple[str, object], int] = {}
        for kind, names in (("now", inputs), (BEFORE, inputs), ("constant", list(self._constants))):
            for name in names:
                numbers[kind, name] = len(numbers)
        words = [[_FORMULA.index(op), 0 if of is None else numbers[of]] for op, of in self._code]
        return CompiledReward(
            terms=compile_expressions(self._terms.values()),
            visibility=[terms.index(self._visibility[name]) if name in self._visibility else -1 for name in terms],
            words=[word for pair in words for word in pair],
            constants=list(self._constants),
        )

    def _emit(self, op: str, of: tuple[str, object] | None = None) -> None:
        self._code.append((op, of))

    def _fold(self, op: str, values: Iterable[ast.expr]) -> None:
        """An operation on the first two values, then on the result and the next."""
        for number, value in enumerate(values):
            self._node(value)
            if number:
                self._emit(op)

    def _node(self, node: ast.expr) -> None:
        match node:
            case ast.Constant(value=value):
                self._number(node, value)
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                self._fold(_BINARY[type(op)], (left, right))
            case ast.UnaryOp(op=op, operand=operand) if type(op) in UNARY:
                self._node(operand)
                self._emit(UNARY[type(op)])
            case ast.Compare(left=left, ops=ops, comparators=rights) if all(type(op) in COMPARE for op in ops):
                for number, (a, comparison, b) in enumerate(zip([left, *rights], ops, rights, strict=False)):
                    self._fold(COMPARE[type(comparison)], (a, b))
                    if number:
                        self._emit("both")
            case ast.BoolOp(op=op, values=values):
                self._fold("both" if isinstance(op, ast.And) else "either", values)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                for part in (test, body, orelse):
                    self._node(part)
                self._emit("choose")
            case ast.Call(func=ast.Name(id=function), args=arguments) if function in _FUNCTIONS:
                op_name, fewest, most = _FUNCTIONS[function]
                self._check_call(node, fewest, most)
                self._fold(op_name, arguments)
                if fewest == 1:
                    self._emit(op_name)
            case ast.Call(func=ast.Name(id="visible"), args=arguments):
                self._check_call(node, 1, 1)
                self._visible(arguments[0])
            case _:
                self._input(node)

    def _number(self, node: ast.AST, value: object) -> None:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= MOST:
            self._refuse(node, f"a number is within -{MOST:.1e}..{MOST:.1e}, such as 5 or 0.1")
        self._constants.setdefault(float(value))
        self._emit("load", ("constant", float(value)))

    def _input(self, node: ast.expr) -> None:
        """A name, or a number of RAM, after the step or before it."""
        time, plain = _timed(node)
        read = self._name(node, plain.id) if isinstance(plain, ast.Name) else self._term(node, plain)
        self._emit("load", (time, read))

    def _name(self, node: ast.AST, name: str) -> str:
        if name in OWN_NAMES:
            return name
        label = self._game.ram_labels.get(name)
        if label is None:
            self._refuse_name(node, name)
        self._terms.setdefault(name, over_ram(value_source(label), label.index))
        if label.visible is not None:
            self._visibility[name] = self._visibility_term(name, label.visible, label.index)
        return name

    def _visibility_term(self, name: str, source: str, index: int) -> str:
        term = f"visible({name})"
        self._terms.setdefault(term, over_ram(source, index))
        return term

    def _visible(self, node: ast.expr) -> None:
        """1 if a label is visible, else 0."""
        time, plain = _timed(node)
        label = self._game.ram_labels.get(plain.id) if isinstance(plain, ast.Name) else None
        if not isinstance(plain, ast.Name) or label is None or plain.id in OWN_NAMES:
            self._refuse(node, f"visible() takes a RAM label of {self._game.id}, or before. and such a label")
        if label.visible is None:
            self._number(node, 1)
        else:
            self._emit("load", (time, self._visibility_term(plain.id, label.visible, label.index)))
            self._emit("not")
            self._emit("not")

    def _term(self, node: ast.AST, plain: ast.expr) -> str:
        """A number that the rules' language reads from RAM: ram[a], or a helper."""
        helper = plain.func.id if isinstance(plain, ast.Call) and isinstance(plain.func, ast.Name) else None
        memory = plain.value.id if isinstance(plain, ast.Subscript) and isinstance(plain.value, ast.Name) else None
        if helper not in HELPERS and memory not in MEMORIES:
            self._refuse(node, f"accepted are {_SYNTAX}")
        for part in ast.walk(plain):
            if isinstance(part, ast.Name) and part.id in ("xram", "rng"):
                self._refuse(part, "a reward reads the console's 128 bytes alone, without xram and rng(); use ram[...]")
        for part, problem in problems(plain, frozenset(), ANY_ADDRESSES):
            if isinstance(part, ast.Name):
                problem = f"an argument of {helper}() is a number or ram[...]"
            self._refuse(part, problem)
        term = ast.unparse(plain)
        self._terms.setdefault(term, plain)
        return term

    def _check_call(self, node: ast.Call, fewest: int, most: int) -> None:
        if node.keywords or not fewest <= len(node.args) <= most:
            count = f"{fewest}" if fewest == most else f"{fewest} to {most}"
            self._refuse(node, f"this function takes {count} value{'' if most == 1 else 's'}")

    def _refuse_name(self, node: ast.AST, name: str) -> NoReturn:
        labels = list(self._game.ram_labels)
        if name == BEFORE:
            self._refuse(node, "before is followed by a dot and a name, such as before.lives")
        if name in _CALLS or name in MEMORIES:
            self._refuse(node, f"accepted are {_SYNTAX}")
        near = difflib.get_close_matches(name, [*OWN_NAMES, *labels], n=1)
        before = f"{BEFORE}." if isinstance(node, ast.Attribute) else ""
        hint = f"did you mean {before + near[0]!r}? Accepted" if near else "accepted"
        known = f"{', '.join(OWN_NAMES)} and the RAM labels of {self._game.id}"
        some = f", such as {', '.join(labels[:5])}" if labels else ", which has none"
        self._refuse(node, f"there is no such name; {hint} are {known}{some}")

    def _refuse(self, node: ast.AST, why: str) -> NoReturn:
        offset = len(self._text.encode()[: getattr(node, "col_offset", 0)].decode())
        stands = (ast.get_source_segment(self._text, node) or self._text[offset:])[:60]
        raise ValueError(f"reward: in {self._text!r}, column {offset + 1}, at {stands!r}: {why}")


def _timed(node: ast.expr) -> tuple[str, ast.expr]:
    """The time of what a node names, and the node without `before`."""
    plain = _without_before(node)
    return ("now", node) if plain is None else (BEFORE, plain)


def _without_before(node: ast.expr) -> ast.expr | None:
    """`x` of `before.x`, `before.ram[a]` or `before.bcd(a)`; None without `before`."""
    match node:
        case ast.Attribute(value=ast.Name(id="before"), attr=name):
            return ast.copy_location(ast.Name(name, ast.Load()), node)
        case ast.Subscript(value=ast.Attribute() as inner, slice=index):
            plain = _without_before(inner)
            return None if plain is None else ast.copy_location(ast.Subscript(plain, index, ast.Load()), node)
        case ast.Call(func=ast.Attribute() as inner, args=arguments, keywords=keywords):
            plain = _without_before(inner)
            return None if plain is None else ast.copy_location(ast.Call(plain, arguments, keywords), node)
    return None
