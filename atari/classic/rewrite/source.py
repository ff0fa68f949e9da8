"""A text of Python with a list of edits: everything outside the edited ranges stays, byte for byte."""

import ast
import re

PREFIX = "# atari.classic: "
"""The beginning of the comment lines that say what a person must check."""


class Source:
    """A text, and the ranges of it to replace. Offsets count characters from the start of the text."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.newline = "\r\n" if "\r\n" in text else "\n"
        self._starts = [0, *(match.end() for match in re.finditer(r"\r\n|\r|\n", text))]
        self._edits: list[tuple[int, int, str]] = []
        self._marks: set[tuple[int, str]] = set()

    def offset(self, line: int, column: int) -> int:
        """The offset of a place of the syntax tree, whose lines start at 1 and whose columns count bytes of UTF-8."""
        start = self._starts[line - 1]
        row = self.text[start : self.line_end(line)]
        return start + (column if row.isascii() else len(row.encode()[:column].decode()))

    def line_end(self, line: int) -> int:
        """The offset of the end of a line, before its line break."""
        if line >= len(self._starts):
            return len(self.text)
        end = self._starts[line]
        return end - (2 if self.text.endswith("\r\n", 0, end) else 1)

    def start(self, node: ast.AST) -> int:
        """The offset of the first character of a node."""
        return self.offset(node.lineno, node.col_offset)  # type: ignore[attr-defined]

    def end(self, node: ast.AST) -> int:
        """The offset after the last character of a node."""
        return self.offset(node.end_lineno, node.end_col_offset)  # type: ignore[attr-defined]

    def segment(self, node: ast.AST) -> str:
        """The text of a node."""
        return self.text[self.start(node) : self.end(node)]

    def replace(self, start: int, end: int, text: str) -> None:
        """Replace a range. An edit inside a range that another edit replaces has no effect."""
        self._edits.append((start, end, text))

    def replace_node(self, node: ast.AST, text: str) -> None:
        """Replace the text of a node."""
        self.replace(self.start(node), self.end(node), text)

    def before(self, node: ast.AST, text: str) -> None:
        """Insert a text before a node."""
        self.replace(self.start(node), self.start(node), text)

    def after(self, node: ast.AST, text: str) -> None:
        """Insert a text after a node."""
        self.replace(self.end(node), self.end(node), text)

    def add_argument(self, call: ast.Call, text: str) -> None:
        """Add an argument to the end of a call."""
        given = [*call.args, *call.keywords]
        if given:
            self.after(max(given, key=self.end), f", {text}")
        else:
            close = self.end(call) - 1
            self.replace(close, close, text)

    def drop_argument(self, call: ast.Call, argument: ast.AST) -> None:
        """Remove an argument of a call, with the comma before it, or else with the one after it."""
        given = sorted([*call.args, *call.keywords], key=self.start)
        place = given.index(argument)
        if place:
            self.replace(self.end(given[place - 1]), self.end(argument), "")
        elif len(given) > 1:
            self.replace(self.start(argument), self.start(given[1]), "")
        else:
            self.replace_node(argument, "")

    def indent(self, line: int) -> str:
        """The white space at the start of a line."""
        row = self.text[self._starts[line - 1] : self.line_end(line)]
        return row[: len(row) - len(row.lstrip())]

    def begins_line(self, node: ast.AST) -> bool:
        """Whether nothing but white space stands before a node in its line."""
        line = node.lineno  # type: ignore[attr-defined]
        return not self.text[self._starts[line - 1] : self.start(node)].strip()

    def ends_line(self, node: ast.AST) -> bool:
        """Whether nothing but a comment stands after a node in its line."""
        line = node.end_lineno  # type: ignore[attr-defined]
        rest = self.text[self.end(node) : self.line_end(line)].strip()
        return not rest or rest.startswith("#")

    def statement_after(self, node: ast.stmt, text: str) -> None:
        """Insert a statement after another one of the same block."""
        if self.begins_line(node) and self.ends_line(node):
            end = self.line_end(node.end_lineno or node.lineno)
            self.replace(end, end, self.newline + self.indent(node.lineno) + text)
        else:
            self.after(node, f"; {text}")

    def delete(self, node: ast.stmt, alone: bool) -> None:
        """Remove a statement; `pass` takes its place if it stands alone in its block or beside others in its line."""
        if alone or not (self.begins_line(node) and self.ends_line(node)):
            self.replace_node(node, "pass")
            return
        last = node.end_lineno or node.lineno
        self.replace(self._starts[node.lineno - 1], ([*self._starts, len(self.text)])[last], "")

    def mark(self, statement: ast.AST, text: str) -> None:
        """Insert a comment line before a statement that begins its line, unless an earlier rewriting has marked it."""
        line = min([statement, *getattr(statement, "decorator_list", [])], key=self.start).lineno
        row = f"{self.indent(line)}{PREFIX}{text}{self.newline}"
        start = self._starts[line - 1]
        above = self.text[self._starts[max(line - 2, 0)] : start].lstrip()
        if (start, text) in self._marks or above.startswith(PREFIX):
            return
        self._marks.add((start, text))
        self.replace(start, start, row)

    @property
    def marks(self) -> int:
        """The number of comment lines that are inserted."""
        return len(self._marks)

    def result(self, start: int = 0, end: int | None = None) -> str:
        """The text of a range, with its edits."""
        end = len(self.text) if end is None else end
        parts, place = [], start
        ordered = sorted(enumerate(self._edits), key=lambda each: (each[1][0], each[1][1] > each[1][0], each[0]))
        for _, (first, last, text) in ordered:
            if place <= first and last <= end:
                parts += [self.text[place:first], text]
                place = last
        return "".join([*parts, self.text[place:end]])
