"""Jupyter notebooks: the code cells as one script, and the notebook with other sources; outputs stay."""

import ast
import json
import re
from typing import Any

from atari.classic.rewrite.source import Source

_NOT_PYTHON = re.compile(r"%%(?!time\b|timeit\b|capture\b|prun\b)")
_MAGIC = re.compile(r"^([ \t]*)([%!?]|\w[\w. ]*=[ \t]*[%!]|.*\?[ \t]*$)", re.MULTILINE)
_BETWEEN = "\n\n"


class Notebook:
    """A notebook of version 4.

    Attributes:
        script: its code cells as one script. Lines for IPython alone (`%matplotlib`, `!pip`) are comments of the same
            length in it, and cells of another language are missing.

    Raises:
        ValueError: the text is not a notebook of version 4.
    """

    def __init__(self, text: str) -> None:
        self._text = text
        try:
            self._data: dict[str, Any] = json.loads(text)
        except ValueError as error:
            raise ValueError(f"it is not JSON, as notebooks are ({error}); it may be damaged") from error
        if not isinstance(self._data, dict) or not {"cells", "worksheets"} & set(self._data):
            raise ValueError("it is JSON, but not a notebook, which has cells; check the path")
        try:
            cells = [cell for cell in self._data["cells"] if cell["cell_type"] == "code"]
            sources = [("".join(cell["source"]), cell) for cell in cells]
        except (ValueError, LookupError, TypeError) as error:
            raise ValueError("it is not a notebook of version 4; save it again with a Jupyter of today") from error
        self._cells: list[tuple[int, str, dict[str, Any]]] = []
        parts, place = [], 0
        for source, cell in sources:
            if _NOT_PYTHON.match(source):
                continue
            self._cells.append((place, source, cell))
            parts.append(_masked(source) + _BETWEEN)
            place += len(parts[-1])
        self.script = "".join(parts)

    def result(self, edited: Source) -> str:
        """The notebook with the edits of its script; its text as it was if there are none."""
        changed = False
        for start, source, cell in self._cells:
            new = _unmasked(edited.result(start, start + len(source)), source)
            if new != source:
                cell["source"] = new.splitlines(keepends=True) if isinstance(cell["source"], list) else new
                changed = True
        if not changed:
            return self._text
        indent = re.match(r"\{\s*\n( +)", self._text)
        written = json.dumps(
            self._data,
            indent=len(indent[1]) if indent else None,
            ensure_ascii=self._text.isascii() and "\\u" in self._text,
        )
        return written + self._text[len(self._text.rstrip()) :]

    def code(self) -> str:
        """The text of the code cells, each after a line with its number, for a diff."""
        return "".join(f"# cell {number}\n{source}\n" for number, source in self._sources())

    def _sources(self) -> list[tuple[int, str]]:
        cells = enumerate(self._data["cells"], 1)
        return [(number, "".join(cell["source"])) for number, cell in cells if cell["cell_type"] == "code"]


def _masked(source: str) -> str:
    """A cell in which each line for IPython is an expression and a comment, of the same length.

    Such a line is where Python's parser stops; a line that begins with `%` may also continue an expression.
    """
    rows = source.splitlines(keepends=True)
    while True:
        try:
            ast.parse("".join(rows))
        except (SyntaxError, ValueError) as error:
            place = (getattr(error, "lineno", None) or 1) - 1
            if place < len(rows) and (masked := _masked_line(rows[place])) != rows[place]:
                rows[place] = masked
                continue
        return "".join(rows)


def _masked_line(line: str) -> str:
    body = line.rstrip("\r\n")
    if not _MAGIC.match(body) or body.lstrip().startswith("#") or len(body.strip()) < 2:
        return line
    indent = len(body) - len(body.lstrip())
    rest = len(body) - indent
    return body[:indent] + "0#" + "%" * (rest - 2) + line[len(body) :]


def _unmasked(new: str, source: str) -> str:
    """A cell with the lines for IPython of its source again."""
    pairs = zip(source.splitlines(), _masked(source).splitlines(), strict=True)
    lost = iter([line for line, masked in pairs if line != masked])
    return "\n".join(next(lost) if re.fullmatch(r"[ \t]*0#%*", row) else row for row in new.split("\n"))
