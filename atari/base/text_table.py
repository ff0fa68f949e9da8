"""Rows of text with aligned columns; `Table`, also for notebooks; facts by name; whole words in a terminal."""

import html
import os
import re
import shutil
import textwrap
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any


def aligned(rows: Iterable[Sequence[object]], to_right: Callable[[int], bool] = lambda column: False) -> list[str]:
    """Rows as lines of aligned columns, to the left, or to the right where `to_right` of the column is true."""
    texts = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
    columns = [(width, str.rjust if to_right(column) else str.ljust) for column, width in enumerate(widths)]
    return [
        "  ".join(put(cell, width) for cell, (width, put) in zip(row, columns, strict=True)).rstrip() for row in texts
    ]


def fact_lines(name: str, values: Iterable[object]) -> list[str]:
    """A line for each value of a fact, the first with its name."""
    return [f"  {'' if index else name:12}  {value}" for index, value in enumerate(values)]


def for_terminal(text: str, stream: Any) -> str:
    """Lines as lines of whole words, if the stream is a terminal that is narrower; otherwise the text.

    What follows of a line begins below its second column, or two blanks further than the line. Lines with control
    characters, such as a progress bar has, stay.
    """
    if not stream.isatty():
        return text
    width = shutil.get_terminal_size().columns
    if "COLUMNS" not in os.environ:
        with suppress(OSError, ValueError):  # stdout, at which shutil looks, may be a pipe
            width = os.get_terminal_size(stream.fileno()).columns or width
    return "\n".join(_fitted(line, width) for line in text.split("\n"))


def _fitted(line: str, width: int) -> str:
    if len(line) <= width or not line.isprintable():
        return line
    column = re.search(r"(?<=\S) {2,}(?=\S)", line)
    indent = len(line) - len(line.lstrip()) + 2
    if column and column.end() <= width // 2:
        indent = column.end()
    return textwrap.fill(line, width, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)


@dataclass(frozen=True)
class Table:
    """A table; `str` aligns its columns, a notebook shows it as HTML. None is an empty cell.

    Attributes:
        columns: the titles of the columns.
        rows: the rows, each with a cell for each column.
        note: a line below the rows; without rows it is shown alone.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]
    note: str = ""

    @classmethod
    def of(cls, columns: Iterable[str], rows: Iterable[Sequence[Any]], note: str = "") -> "Table":
        """A table of any iterables."""
        return cls(tuple(columns), tuple(map(tuple, rows)), note)

    def __str__(self) -> str:
        if self.note and not self.rows:
            return self.note
        columns = list(zip(*self.rows, strict=True)) if self.rows else [()] * len(self.columns)
        numeric = [all(isinstance(cell, int) or cell is None for cell in column) for column in columns]
        lines = aligned([self.columns, *(tuple(map(_text, row)) for row in self.rows)], numeric.__getitem__)
        return "\n".join([*lines, *filter(None, [self.note])])

    __repr__ = __str__

    def _repr_html_(self) -> str:
        note = f"<p>{html.escape(self.note)}</p>" if self.note else ""
        if note and not self.rows:
            return note
        words = [any(re.search("[A-Za-z]", _text(row[at])) for row in self.rows) for at in range(len(self.columns))]
        align = [' style="text-align:left"' if left else "" for left in words]  # Jupyter has all cells to the right
        head, *rows = (
            "".join(f"<{tag}{style}>{html.escape(_text(cell))}</{tag}>" for cell, style in zip(row, align, strict=True))
            for tag, row in (("th", self.columns), *(("td", row) for row in self.rows))
        )
        body = "".join(f"<tr>{row}</tr>" for row in rows)
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{note}"


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell)
