"""HTML of tables, sheets of pictures and lists, with text that is escaped here."""

from collections.abc import Iterable, Sequence
from html import escape as text


def code(content: object) -> str:
    """Content as code."""
    return f"<code>{text(str(content))}</code>"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells of HTML, which scrolls sideways where it is too wide."""
    cells = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>\n" for row in rows)
    heads = "".join(f"<th>{cell}</th>" for cell in head)
    return f'<div class="facts"><table><thead><tr>{heads}</tr></thead><tbody>\n{cells}</tbody></table></div>\n'


def folded(summary: str, content: str) -> str:
    """Content that a click opens."""
    return f"<details><summary>{text(summary)}</summary>\n{content}</details>\n"


def shape(cells: int) -> tuple[int, int]:
    """(columns, rows) of a sheet of n cells."""
    columns = min(cells, 8)
    return columns, -(-cells // columns)


def pictures(source: str, captions: Sequence[str], *, columns: int | None = None, ratio: str, kind: str) -> str:
    """The cells of a sheet, each with a caption of HTML; `columns` as in `shape` if not given."""
    across, down = shape(len(captions)) if columns is None else (columns, -(-len(captions) // columns))
    parts = [f'<div class="sheet {kind}">']
    for number, caption in enumerate(captions):
        x = 100 * (number % across) / max(1, across - 1)
        y = 100 * (number // across) / max(1, down - 1)
        style = f"background: url({source}) {x:.4g}% {y:.4g}% / {across * 100}% {down * 100}%; aspect-ratio: {ratio}"
        parts.append(f'<figure><span style="{style}"></span><figcaption>{caption}</figcaption></figure>')
    return "\n".join([*parts, "</div>\n"])
