"""Displays of environments, games and replays in a notebook: HTML that contains its images."""

import base64
import html
import re
from collections.abc import Sequence
from typing import Any

from atari.base.text_table import Table

MOST_SHOWN = 36
"""The most environments of a vector that a notebook shows."""


def picture(data: bytes, caption: str, shape: Sequence[int]) -> str:
    """HTML of a PNG file of screens, see `image`, with a caption below."""
    shown = image(data, caption, shape)
    return f'<figure style="margin:0">{shown}<figcaption>{html.escape(caption)}</figcaption></figure>'


def image(data: bytes, text: str, shape: Sequence[int]) -> str:
    """An HTML image of a PNG file of one or more screens, at most as wide as the page, with a text for readers.

    `shape` begins with the rows and columns of the file. The pixels of a screen are twice as wide as high, and a
    browser takes the aspect of the file for `height:auto`. So the style has the aspect of the attributes.
    """
    width, height = 2 * shape[1], shape[0]
    style = f"image-rendering:pixelated;max-width:100%;height:auto;aspect-ratio:{width}/{height}"
    return (
        f'<img width="{width}" height="{height}" alt="{html.escape(text)}" style="{style}" '
        f'src="data:image/png;base64,{base64.b64encode(data).decode()}">'
    )


def facts(title: str, rows: Sequence[tuple[str, Any]], note: str = "") -> str:
    """HTML of a table with a name and a value a row, without the rows whose value is None or empty."""
    body = "".join(
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(str(value))}</td></tr>'
        for name, value in rows
        if value not in (None, "")
    )
    below = f"<p>{html.escape(note)}</p>" if note else ""
    return f"<p><strong>{html.escape(title)}</strong></p>{below}<table><tbody>{body}</tbody></table>"


def report(text: str) -> str:
    """HTML of what an object prints: a title line, sentences, and tables, which have an empty line before and after.

    A table is a paragraph of columns as `text_table.aligned` makes them, with two or more spaces between them in all
    lines; its first line has the titles.
    """
    title, _, rest = text.partition("\n")
    return f"<p><strong>{html.escape(title)}</strong></p>" + "".join(map(_paragraph, rest.split("\n\n")))


def _paragraph(text: str) -> str:
    lines = text.strip("\n").split("\n")
    width = max(map(len, lines))
    used = "".join("x" if any(line[at : at + 1].strip() for line in lines) else " " for at in range(width))
    columns = [slice(*match.span()) for match in re.finditer(r"x+( x+)*", used)]
    if len(lines) > 1 and len(columns) > 1:
        head, *rows = ([line[column].strip() for column in columns] for line in lines)
        return f'<div style="margin:1em 0">{Table.of(head, rows)._repr_html_()}</div>'
    return "".join(f"<p>{html.escape(line)}</p>" for line in lines)
