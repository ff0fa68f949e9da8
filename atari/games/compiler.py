"""Compiles the rules of a game definition to programs for the native core's stack machine.

An expression is parsed by Python's own `ast` (after `atari.games.rules` has checked it against the grammar) and becomes
pairs of words, operation and argument, in the numbering of `Op` in `atari/emulator/ale/programs/program.hpp`. Selecting
a mode becomes a program of the same kind with loops. The native core checks every program again before it runs one.
"""

import ast
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from atari.games.actions import Action
from atari.games.rules import Operation, Rules

OPERATIONS = (
    "push load store ram xram add subtract multiply divide modulo and or xor shift_left shift_right "
    "equal not_equal less less_equal greater greater_equal negate invert not jump jump_if_zero "
    "jump_if_zero_else_pop jump_if_not_zero_else_pop bcd signed8 count same positive_sum negative_sum "
    "random random_between press_select soft_reset act fail end"
).split()
"""Names of the operations; an operation's index is its number."""

_NUMBER = {name: number for number, name in enumerate(OPERATIONS)}
BINARY: dict[type[ast.operator], str] = {
    ast.Add: "add", ast.Sub: "subtract", ast.Mult: "multiply", ast.FloorDiv: "divide", ast.Mod: "modulo",
    ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor", ast.LShift: "shift_left", ast.RShift: "shift_right",
}  # fmt: skip
COMPARE: dict[type[ast.cmpop], str] = {
    ast.Eq: "equal", ast.NotEq: "not_equal", ast.Lt: "less", ast.LtE: "less_equal", ast.Gt: "greater",
    ast.GtE: "greater_equal",
}  # fmt: skip
UNARY: dict[type[ast.unaryop], str] = {ast.USub: "negate", ast.Invert: "invert", ast.Not: "not"}
"""The operations of the syntax tree's operators, which rewards use, too."""

_CALLS = {"s8": "signed8", "same": "same", "pos_sum": "positive_sum", "neg_sum": "negative_sum", "rng": "random",
          "random": "random_between"}  # fmt: skip


@dataclass(frozen=True)
class CompiledRules:
    """Rules for the native core: programs, and variables by number."""

    variables: int
    initial: list[int]
    kept: list[bool]
    outputs: list[int]
    step: list[int]
    select_mode: list[int]


def compile_rules(rules: Rules) -> CompiledRules:
    """Compile the rules of a game. The numbers of variables begin with those of `state`, in their order."""
    names = dict.fromkeys([*rules.state, *rules.outputs, "terminal", "mode", *(name for name, _ in rules.step)])
    numbers = {name: number for number, name in enumerate(names)}
    step = _Assembler(numbers)
    for name, source in rules.step:
        step.expression(source)
        step.emit("store", numbers[name])
    select_mode = _Assembler(numbers)
    select_mode.operations(rules.mode_select)
    return CompiledRules(
        variables=len(numbers),
        initial=list(rules.state.values()),
        kept=[name in rules.kept_over_reset for name in rules.state],
        outputs=[numbers[name] for name in ("terminal", "mode", *rules.outputs)],
        step=step.finish(),
        select_mode=select_mode.finish(),
    )


def compile_expression(tree: ast.Expression, numbers: Mapping[str, int], result: int) -> list[int]:
    """Compile a checked expression to a program that stores its value in the variable `result`."""
    assembler = _Assembler(dict(numbers))
    assembler.node(tree.body)
    assembler.emit("store", result)
    return assembler.finish()


def compile_expressions(trees: Iterable[ast.expr]) -> list[int]:
    """Compile checked expressions without variables to a program that stores value i in variable i."""
    assembler = _Assembler({})
    for number, tree in enumerate(trees):
        assembler.node(tree)
        assembler.emit("store", number)
    return assembler.finish()


class _Assembler:
    """Collects instructions; `numbers` are the variables; hidden ones may be added."""

    def __init__(self, numbers: dict[str, int]) -> None:
        self._numbers = numbers
        self._code: list[list[int]] = []

    def emit(self, name: str, argument: int = 0) -> list[int]:
        """Append an instruction and return it, so that a jump's target can be filled in."""
        self._code.append([_NUMBER[name], argument])
        return self._code[-1]

    def finish(self) -> list[int]:
        self.emit("end")
        return [word for instruction in self._code for word in instruction]

    def expression(self, source: str) -> None:
        self.node(ast.parse(source.strip(), mode="eval").body)

    def operations(self, operations: Sequence[Operation]) -> None:
        for operation in operations:
            self._operation(operation)

    def _here(self) -> int:
        return len(self._code)

    def node(self, node: ast.expr) -> None:
        match node:
            case ast.Constant(value=int(value)):
                self.emit("push", value)
            case ast.Name(id=name):
                self.emit("load", self._numbers[name])
            case ast.Subscript(value=ast.Name(id=memory), slice=index):
                self.node(index)
                self.emit(memory)
            case ast.BinOp(left=left, op=op, right=right):
                self.node(left)
                self.node(right)
                self.emit(BINARY[type(op)])
            case ast.UnaryOp(op=op, operand=operand):
                self.node(operand)
                self.emit(UNARY[type(op)])
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                self.node(left)
                self.node(right)
                self.emit(COMPARE[type(op)])
            case ast.Compare(left=left, ops=ops, comparators=rights):
                pairs = zip([left, *rights], ops, rights, strict=False)
                self._bool(True, [ast.Compare(a, [op], [b]) for a, op, b in pairs])
            case ast.BoolOp(op=op, values=values):
                self._bool(isinstance(op, ast.And), values)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                self.node(test)
                otherwise = self.emit("jump_if_zero")
                self.node(body)
                end = self.emit("jump")
                otherwise[1] = self._here()
                self.node(orelse)
                end[1] = self._here()
            case ast.Call(func=ast.Name(id=helper), args=arguments):
                for argument in arguments:
                    self.node(argument)
                if helper in ("bcd", "count"):
                    self.emit(helper, len(arguments))
                else:
                    self.emit(_CALLS[helper])
            case _:  # pragma: no cover - atari.games.rules has checked the grammar
                raise ValueError(f"{ast.unparse(node)!r} is not part of the language of rules")

    def _bool(self, is_and: bool, values: list[ast.expr]) -> None:
        leave = "jump_if_zero_else_pop" if is_and else "jump_if_not_zero_else_pop"
        self.node(values[0])
        jumps = []
        for value in values[1:]:
            jumps.append(self.emit(leave))
            self.node(value)
        for jump in jumps:
            jump[1] = self._here()

    def _until(self, condition: str, body: Callable[[], object]) -> None:
        start = self._here()
        self.expression(condition)
        self.emit("not")
        done = self.emit("jump_if_zero")
        body()
        self.emit("jump", start)
        done[1] = self._here()

    def _times(self, count: str, body: Callable[[], object]) -> None:
        counter = self._count_from(count)
        start = self._here()
        done = self._jump_if_counted_down(counter)
        body()
        self._count_down(counter)
        self.emit("jump", start)
        done[1] = self._here()

    def _count_from(self, count: str) -> int:
        """Set a hidden variable to an expression, and return its number."""
        counter = len(self._numbers)
        self._numbers[f"#{counter}"] = counter
        self.expression(count)
        self.emit("store", counter)
        return counter

    def _jump_if_counted_down(self, counter: int) -> list[int]:
        for name, argument in (("load", counter), ("push", 0), ("greater", 0)):
            self.emit(name, argument)
        return self.emit("jump_if_zero")

    def _count_down(self, counter: int) -> None:
        for name, argument in (("load", counter), ("push", 1), ("subtract", 0), ("store", counter)):
            self.emit(name, argument)

    def _operation(self, operation: Operation) -> None:
        """Append one operation; `atari.games.rules` has checked its keys."""
        value, frames, until, times = (
            text or "0" for text in (operation.value, operation.frames, operation.until, operation.times)
        )
        match operation.op:
            case "set":
                self.expression(value)
                self.emit("store", self._numbers.setdefault(str(operation.var), len(self._numbers)))
            case "press_select":
                self._press(frames)
            case "press_select_until" if operation.max is not None:
                self._press_until(until, frames, operation.max)
            case "press_select_until":
                self._until(until, lambda: self._press(frames))
            case "soft_reset":
                self.emit("soft_reset")
            case "act":
                self._times(times, lambda: self._act(operation))
            case "act_until":
                self._until(until, lambda: self._act(operation))
            case "repeat_until":
                self._until(until, lambda: self.operations(operation.do))
            case "repeat":
                self._times(times, lambda: self.operations(operation.do))

    def _press(self, frames: str) -> None:
        self.expression(frames)
        self.emit("press_select")

    def _act(self, operation: Operation) -> None:
        self.emit("act", Action[str(operation.action)])

    def _press_until(self, condition: str, frames: str, most: int) -> None:
        """Press SELECT until the condition holds; more than `most` presses are a failure."""
        counter = self._count_from(str(most))
        start = self._here()
        self.expression(condition)
        self.emit("not")
        done = self.emit("jump_if_zero")
        exhausted = self._jump_if_counted_down(counter)
        self._press(frames)
        self._count_down(counter)
        self.emit("jump", start)
        exhausted[1] = self._here()
        self.emit("fail")
        done[1] = self._here()
