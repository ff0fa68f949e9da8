"""Rewards of tasks in plain Python: an interpreter of the syntax tree, the reference of the compiler and of the C++."""

import ast
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import atari
from atari.lab.labels import labels_of

LARGEST = float(np.finfo(np.float32).max)


@dataclass(frozen=True)
class Moment:
    """The state after a step, or after a reset with `reward=0`."""

    ram: npt.NDArray[np.uint8]
    lives: int
    reward: float = 0.0
    lives_lost: int = 0


def after(before: Moment, ram: npt.NDArray[np.uint8], lives: int, reward: float) -> Moment:
    return Moment(ram, lives, reward, max(before.lives - lives, 0))


def value(game: str, text: str, now: Moment, before: Moment) -> float:
    """The reward of a step from `before` to `now`."""
    reader = _Reader(game, now, before)
    return reader.value(ast.parse(text, mode="eval").body) + 0.0  # no negative zero


class _Reader:
    def __init__(self, game: str, now: Moment, before: Moment) -> None:
        self.times = {"now": now, "before": before}
        self.labels = {name: labels_of(atari.games[game]).values(one.ram) for name, one in self.times.items()}

    def value(self, node: Any) -> float:
        return limited(self._value(node))

    def _value(self, node: Any) -> float:
        match node:
            case ast.Constant(value=number):
                return float(number)
            case ast.Name(id=name):
                return self.named("now", name)
            case ast.Attribute(value=ast.Name(id="before"), attr=name):
                return self.named("before", name)
            case ast.BinOp(left=left, op=op, right=right):
                return BINARY[type(op)](self.value(left), self.value(right))
            case ast.UnaryOp(op=op, operand=operand):
                return UNARY[type(op)](self.value(operand))
            case ast.Compare(left=left, ops=ops, comparators=rights):
                values = [self.value(one) for one in (left, *rights)]
                pairs = zip(values, ops, values[1:], strict=False)
                return float(all(COMPARE[type(op)](a, b) for a, op, b in pairs))
            case ast.BoolOp(op=op, values=parts):
                values = [self.value(part) for part in parts]
                stops = [one for one in values[:-1] if (one == 0) == isinstance(op, ast.And)]
                return stops[0] if stops else values[-1]
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return self.value(body) if self.value(test) else self.value(orelse)
            case ast.Call(func=ast.Name(id="visible"), args=[ast.Name(id=name)]):
                return float(self.labels["now"][name] is not None)
            case ast.Call(func=ast.Name(id="visible"), args=[ast.Attribute(attr=name)]):
                return float(self.labels["before"][name] is not None)
            case ast.Call(func=ast.Name(id=name), args=args) if name in ("abs", "min", "max"):
                return float(FUNCTIONS[name](*map(self.value, args)))
            case ast.Call(func=ast.Name(id=name), args=args):
                return float(self.of_ram("now", name, args))
            case ast.Call(func=ast.Attribute(attr=name), args=args):
                return float(self.of_ram("before", name, args))
            case ast.Subscript(value=ast.Name(), slice=ast.Constant(value=address)):
                return float(self.byte("now", address))
            case ast.Subscript(value=ast.Attribute(), slice=ast.Constant(value=address)):
                return float(self.byte("before", address))
        raise AssertionError(ast.dump(node))

    def named(self, time: str, name: str) -> float:
        if name in ("reward", "lives", "lives_lost"):
            return float(getattr(self.times[time], name))
        other = "now" if time == "before" else "before"
        shown = [one for one in (self.labels[time][name], self.labels[other][name]) if one is not None]
        return float(shown[0]) if shown else 0.0

    def byte(self, time: str, address: int) -> int:
        return int(self.times[time].ram[address - 0x80])

    def integer(self, time: str, node: Any) -> int:
        if isinstance(node, ast.Constant):
            return int(node.value)
        return self.byte(time, node.slice.value)

    def of_ram(self, time: str, helper: str, args: list[Any]) -> int:
        first, *rest = (self.integer(time, one) for one in args)
        if helper == "s8":
            return (first + 128) % 256 - 128
        if helper == "bcd":
            digits = [self.byte(time, address) for address in (first, *rest)]
            return sum(100**place * (10 * (byte >> 4) + (byte & 15)) for place, byte in enumerate(digits))
        range_ = [self.byte(time, address) for address in range(first, rest[0] + 1)]
        signed = [(byte + 128) % 256 - 128 for byte in range_]
        match helper:
            case "count":
                return sum(byte in rest[1:] for byte in range_)
            case "same":
                return int(all(byte == range_[0] for byte in range_))
            case "pos_sum":
                return sum(byte for byte in signed if byte > 0)
            case "neg_sum":
                return -sum(byte for byte in signed if byte < 0)
        raise AssertionError(helper)


def limited(number: float) -> float:
    assert not math.isnan(number)
    return min(max(number, -LARGEST), LARGEST)


def whole(number: float) -> int:
    return int(min(max(number, -(2.0**53)), 2.0**53))


FUNCTIONS: dict[str, Any] = {"abs": abs, "min": min, "max": max}
BINARY: dict[type, Any] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b if b else 0.0,
    ast.FloorDiv: lambda a, b: a // b if b else 0.0,
    ast.Mod: lambda a, b: a % b if b else 0.0,
    ast.BitAnd: lambda a, b: float(whole(a) & whole(b)),
    ast.BitOr: lambda a, b: float(whole(a) | whole(b)),
    ast.BitXor: lambda a, b: float(whole(a) ^ whole(b)),
    ast.LShift: lambda a, b: float(whole(a) << (whole(b) & 31)),
    ast.RShift: lambda a, b: float(whole(a) >> (whole(b) & 31)),
}
UNARY: dict[type, Any] = {
    ast.USub: lambda a: -a,
    ast.Invert: lambda a: float(~whole(a)),
    ast.Not: lambda a: float(a == 0),
}
COMPARE: dict[type, Any] = {
    ast.Eq: lambda a, b: a == b,
    ast.NotEq: lambda a, b: a != b,
    ast.Lt: lambda a, b: a < b,
    ast.LtE: lambda a, b: a <= b,
    ast.Gt: lambda a, b: a > b,
    ast.GtE: lambda a, b: a >= b,
}
