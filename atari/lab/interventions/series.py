"""`evaluate_series` evaluates an expression of the rules' language on a recorded history of RAM, all frames at once."""

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Series = npt.NDArray[np.int64]


def _floor(function: Callable[[Series, Series], Series]) -> Callable[[Series, Series], Series]:
    """The division whose result for a divisor of zero or less is 0, as in the native core."""

    def divided(left: Series, right: Series) -> Series:
        good = right > 0
        return np.where(good, function(left, np.where(good, right, 1)), 0)

    return divided


_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.FloorDiv: _floor(operator.floordiv), ast.Mod: _floor(operator.mod),
    ast.BitAnd: operator.and_, ast.BitOr: operator.or_, ast.BitXor: operator.xor,
    ast.LShift: lambda left, right: left << (right & 31), ast.RShift: lambda left, right: left >> (right & 31),
}  # fmt: skip
_COMPARE: dict[type, Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}  # fmt: skip
_UNARY: dict[type, Callable[[Any], Any]] = {
    ast.USub: operator.neg, ast.Invert: operator.invert, ast.Not: lambda value: value == 0
}  # fmt: skip


def evaluate_series(tree: ast.Expression, ram: npt.NDArray[np.uint8], names: Mapping[str, Series]) -> Series:
    """The values of a checked expression.

    Args:
        tree: the expression, without labels (`parse_expression` replaces them).
        ram: (frames, 128) uint8.
        names: the series of its variables, (frames,) each.

    Returns:
        (frames,) int64.
    """
    return np.broadcast_to(_Evaluator(ram.astype(np.int64), names).value(tree.body), (len(ram),)).astype(np.int64)


class _Evaluator:
    def __init__(self, ram: Series, names: Mapping[str, Series]) -> None:
        self._ram, self._names = ram, names

    def value(self, node: ast.expr) -> Series:
        match node:
            case ast.Constant(value=int(value)):
                return np.array(value, np.int64)
            case ast.Name(id=name):
                return self._names[name]
            case ast.Subscript(value=ast.Name(id="ram"), slice=ast.Constant(value=int(place))):
                return self._ram[:, place & 127]
            case ast.BinOp(left=left, op=op, right=right):
                return np.asarray(_BINARY[type(op)](self.value(left), self.value(right)))
            case ast.UnaryOp(op=op, operand=operand):
                return _number(_UNARY[type(op)](self.value(operand)))
            case ast.Compare(left=left, ops=ops, comparators=rights):
                values = [self.value(each) for each in (left, *rights)]
                pairs = zip(ops, values, values[1:], strict=False)
                return _number(np.logical_and.reduce([_COMPARE[type(op)](a, b) for op, a, b in pairs]))
            case ast.BoolOp(op=op, values=parts):
                return self._bool(isinstance(op, ast.And), parts)
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return np.where(self.value(test) != 0, self.value(body), self.value(orelse))
            case ast.Call(func=ast.Name(id=helper), args=arguments):
                return self._call(helper, [self.value(each) for each in arguments])
        raise ValueError(f"{ast.unparse(node)!r} cannot be evaluated on a history of RAM")

    def _bool(self, is_and: bool, parts: list[ast.expr]) -> Series:
        value = self.value(parts[0])
        for part in parts[1:]:
            value = np.where((value != 0) == is_and, self.value(part), value)
        return value

    def _call(self, helper: str, values: list[Series]) -> Series:
        if helper == "s8":
            return (values[0] + 128 & 255) - 128
        if helper == "bcd":
            digits = [self._ram[:, int(place) & 127] for place in values]
            return np.asarray(sum((10 * (byte >> 4) + (byte & 15)) * 100**i for i, byte in enumerate(digits)))
        if helper not in ("count", "same", "pos_sum", "neg_sum"):
            raise ValueError(f"{helper}() cannot be evaluated on a history of RAM")
        low, high = (int(place) & 127 for place in values[:2])
        part = self._ram[:, low : high + 1]
        if helper == "count":
            return np.asarray(np.logical_or.reduce([part == value[..., None] for value in values[2:]]).sum(1))
        if helper == "same":
            return _number((part == part[:, :1]).all(1))
        signed = (part + 128 & 255) - 128
        return np.asarray(np.maximum(signed if helper == "pos_sum" else -signed, 0).sum(1))


def _number(truth: Any) -> Series:
    return np.asarray(truth, np.int64)
