"""Makes mutants of a source file: the same file with one small change that a test should notice.

The kinds: an operator replaced by its neighbour, a constant changed by one or a truth value turned over, a condition
negated, a call or a raised error deleted. Python is read by its syntax tree. C++ is read line by line, without
comments, strings and preprocessor lines; an operator there has a space on both sides, as the formatter writes it.
"""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

KINDS = ("operator", "constant", "condition", "deleted call")


@dataclass(frozen=True)
class Mutant:
    """One change: the characters `start` to `end` of a file are replaced."""

    file: str
    kind: str
    start: int
    end: int
    new: str

    def apply(self, text: str) -> str:
        """The file's text with the change."""
        return text[: self.start] + self.new + text[self.end :]

    def describe(self, text: str) -> str:
        """The place and both forms of the line, for a report."""
        line = text.count("\n", 0, self.start) + 1
        first = text.rfind("\n", 0, self.start) + 1
        before = text[first : text.find("\n", self.end)].strip()
        after = (text[first : self.start] + self.new + text[self.end : text.find("\n", self.end)]).strip()
        shown = (" ".join(form.split())[:100] for form in (before, after))
        return f"{self.file}:{line} ({self.kind}) " + " -> ".join(shown)


def mutants(file: str, text: str) -> list[Mutant]:
    """All mutants of a file, in the order of the text."""
    found = _of_python(text) if Path(file).suffix == ".py" else _of_cpp(text)
    return [Mutant(file, *change) for change in sorted(set(found))]


Change = tuple[str, int, int, str]
"""Kind, start, end and the new text."""

_PYTHON_OPERATORS: dict[type[ast.AST], tuple[str, str]] = {
    ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="), ast.NotEq: ("!=", "=="), ast.Is: ("is", "is not"), ast.IsNot: ("is not", "is"),
    ast.In: ("in", "not in"), ast.NotIn: ("not in", "in"), ast.And: ("and", "or"), ast.Or: ("or", "and"),
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "+"), ast.FloorDiv: ("//", "*"), ast.Div: ("/", "*"),
    ast.Mod: ("%", "*"), ast.BitAnd: ("&", "|"), ast.BitOr: ("|", "&"), ast.LShift: ("<<", ">>"),
    ast.RShift: (">>", "<<"),
}  # fmt: skip


def _of_python(text: str) -> Iterator[Change]:
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))

    def span(node: ast.expr | ast.stmt) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset

    def replaced(between: tuple[ast.expr, ast.expr], operator: ast.AST) -> Iterator[Change]:
        """The operator between two operands; nothing but spaces and parentheses may stand beside it."""
        old, new = _PYTHON_OPERATORS.get(type(operator), ("", ""))
        first, last = span(between[0])[1], span(between[1])[0]
        place = re.fullmatch(rf"[\s()]*({re.escape(old)})[\s()]*", text[first:last]) if old else None
        if place:
            yield "operator", first + place.start(1), first + place.end(1), new

    # The columns of the syntax tree count bytes.
    for node in _executed(ast.parse("".join(letter if letter.isascii() else "x" for letter in text))):
        if isinstance(node, ast.Compare):
            operands = [node.left, *node.comparators]
            for operator, pair in zip(node.ops, pairwise(operands), strict=True):
                yield from replaced(pair, operator)
        elif isinstance(node, ast.BinOp):
            yield from replaced((node.left, node.right), node.op)
        elif isinstance(node, ast.BoolOp):
            yield from replaced((node.values[0], node.values[1]), node.op)
        elif isinstance(node, ast.Constant) and type(node.value) in (int, bool):
            new = not node.value if isinstance(node.value, bool) else node.value + 1
            yield "constant", *span(node), str(new)
        elif isinstance(node, ast.If | ast.While | ast.IfExp):
            start, end = span(node.test)
            yield "condition", start, end, f"(not ({text[start:end]}))"
        elif isinstance(node, ast.Raise) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)):
            yield "deleted call", *span(node), "pass"


def _executed(tree: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a tree without annotations, which have no effect, and imports for type checkers."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "type_comment") or (isinstance(tree, ast.Assign) and _is_alias(tree)):
            continue
        for node in value if isinstance(value, list) else [value]:
            if isinstance(node, ast.AST) and "TYPE_CHECKING" not in ast.dump(getattr(node, "test", node))[:60]:
                yield node
                yield from _executed(node)


def _is_alias(node: ast.Assign) -> bool:
    """Whether an assignment names a type: a union, or a subscript of a name in capitals."""
    value = node.value
    while isinstance(value, ast.BinOp) and isinstance(value.op, ast.BitOr):
        value = value.left
    return (
        isinstance(node.value, ast.BinOp | ast.Subscript)
        and isinstance(value, ast.Subscript | ast.Name)
        and (ast.unparse(node.targets[0])[:1].isupper() and not ast.unparse(node.targets[0]).isupper())
    )


_CPP_OPERATORS = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&", "+": "-", "-": "+",
    "*": "+", "/": "*", "%": "*", "&": "|", "|": "&", "<<": ">>", ">>": "<<", "+=": "-=", "-=": "+=", "|=": "&=",
}  # fmt: skip
_CPP_OPERATOR = re.compile(r"(?<= )(?:<=|>=|==|!=|&&|\|\||<<|>>|\+=|-=|\|=|[<>+\-*/%&|])(?= )")
_CPP_CONSTANT = re.compile(r"(?<![\w.'])(?:0x[0-9a-fA-F]+|\d+|true|false)(?![\w.'])")
_CPP_CONDITION = re.compile(r"\b(?:if|while) \(")
_CPP_STATEMENT = re.compile(r"(?<=[;{}\n])\s*((?!return|else|delete|case|using|static_assert)[\w.:>-]+\([^;{}]*\));")
_CPP_THROW = re.compile(r"\bthrow [^;]*;")
_CPP_NO_CODE = re.compile(
    r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])'|^[ ]*#(?:[^\n]*\\\n)*[^\n]*",
    re.DOTALL | re.MULTILINE,
)
_CPP_NO_EFFECT = re.compile(r"\bstatic_assert\([^;]*;|\btemplate <[^\n]*>", re.DOTALL)


def _of_cpp(text: str) -> Iterator[Change]:
    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    code = _CPP_NO_EFFECT.sub(blank, _CPP_NO_CODE.sub(blank, text))
    for found in _CPP_OPERATOR.finditer(code):
        yield "operator", *found.span(), _CPP_OPERATORS[found[0]]
    for found in _CPP_CONSTANT.finditer(code):
        turned = {"true": "false", "false": "true"}.get(found[0])
        yield "constant", *found.span(), turned or str(int(found[0], 0) + 1)
    for found in _CPP_CONDITION.finditer(code):
        end = _closing(code, found.end() - 1)
        inside = text[found.end() : end]
        if end > 0 and ";" not in inside and not re.match(r"(?:const )?auto", inside) and "constexpr" not in found[0]:
            yield "condition", found.end(), end, f"!({inside})"
    for found in _CPP_STATEMENT.finditer(code):
        yield "deleted call", *found.span(1), ""
    for found in _CPP_THROW.finditer(code):
        yield "deleted call", *found.span(), ";"


def _closing(code: str, opening: int) -> int:
    """The place of the parenthesis that closes the one at `opening`, or -1."""
    depth = 0
    for place in range(opening, len(code)):
        depth += {"(": 1, ")": -1}.get(code[place], 0)
        if depth == 0:
            return place
    return -1
