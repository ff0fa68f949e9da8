"""The value of a RAM label as an expression of its byte, and as a program of the extension module."""

import ast

from atari.games.compiler import compile_expression
from atari.games.game import RamLabel

_BYTE, _RESULT = 0, 1  # variables of `Label` in atari/emulator/ale/programs/labels.hpp


def value_source(label: RamLabel) -> str:
    """The value of a label as an expression over `v`, its byte, and `ram[0..127]`.

    It is the label's `transform`; without one, the two decimal digits of a byte encoded as "bcd", else the bits of its
    mask. A `weight` multiplies it, so that a byte of a score counts in points.
    """
    if label.transform is not None:
        value = label.transform
    else:
        bits = "v" if label.mask is None else f"(v & {label.mask})"
        value = f"10 * ({bits} >> 4) + ({bits} & 15)" if label.encoding == "bcd" else bits
    return value if label.weight in (None, 1) else f"({value}) * {label.weight}"


def over_ram(source: str, index: int) -> ast.expr:
    """An expression of a label, with `v` replaced by the label's byte."""
    return _Byte(index).visit(ast.parse(source.strip(), mode="eval")).body


class _Byte(ast.NodeTransformer):
    def __init__(self, index: int) -> None:
        self._byte = ast.Subscript(ast.Name("ram", ast.Load()), ast.Constant(index), ast.Load())

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self._byte if node.id == "v" else node


def compile_label(label: RamLabel) -> tuple[int, int, bool, list[int], list[int]]:
    """A label for `_emulator.Labels`: index, mask, whether it is decimal, two programs."""
    programs = [
        compile_expression(ast.parse(source.strip(), mode="eval"), {"v": _BYTE}, _RESULT) if source else []
        for source in (value_source(label), label.visible)
    ]
    mask = 255 if label.mask is None else label.mask
    return label.index, mask, label.encoding == "bcd", programs[0], programs[1]
