"""`Table`: rows of text that print in a terminal and show in a notebook."""

import html
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Table:
    """A table; `str` aligns its columns, a notebook shows it as HTML. None is an empty cell.

    Attributes:
        columns: the titles of the columns.
        rows: the rows, each with a cell for each column.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    @classmethod
    def of(cls, columns: Iterable[str], rows: Iterable[Sequence[Any]]) -> "Table":
        """A table of any iterables."""
        return cls(tuple(columns), tuple(map(tuple, rows)))

    def __str__(self) -> str:
        texts = [self.columns, *(tuple(map(_text, row)) for row in self.rows)]
        widths = [max(map(len, column)) for column in zip(*texts, strict=True)]
        columns = zip(*self.rows, strict=True) if self.rows else [()] * len(self.columns)
        numeric = [all(isinstance(cell, int) or cell is None for cell in column) for column in columns]
        lines = []
        for row in texts:
            cells = zip(row, widths, numeric, strict=True)
            lines.append(
                "  ".join(cell.rjust(width) if right else cell.ljust(width) for cell, width, right in cells).rstrip()
            )
        return "\n".join(lines)

    __repr__ = __str__

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{html.escape(title)}</th>" for title in self.columns)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(_text(cell))}</td>" for cell in row) + "</tr>" for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell)
