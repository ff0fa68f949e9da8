"""The pages of the notebooks of docs/notebooks/, with the outputs of a run."""

import base64
import html
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from documents import ROOT, relink
from notebook_runs import SHORT, kept_run
from page import Page

FOLDER = ROOT / "docs" / "notebooks"
_PICTURE = re.compile(r"data:image/png;base64,([A-Za-z0-9+/=]+)")
_TAG_GAPS = re.compile(r"\s*\n\s*")


def pages() -> Iterator[Page]:
    """A page of Markdown for each notebook, and its pictures as files."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        yield from _Notebook(path).pages()


class _Notebook:
    """A notebook as a page. Pictures in its outputs become files beside the page."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.pictures: list[Page] = []

    def pages(self) -> Iterator[Page]:
        parts = [part for cell in kept_run(self.path).cells for part in self._cell(cell)]
        # After the title, which is the first line.
        title, _, rest = parts[0].partition("\n")
        link = f"[Download this notebook]({self.path.name}) to run it yourself."
        if short := SHORT.get(self.path.stem):
            values = " and ".join(f"`{name} = {value:_}`" for name, value in short.items())
            link += f" The outputs on this page are of a run with {values}."
        yield Page(f"notebooks/{self.path.stem}.md", "\n\n".join((title, link, rest.strip(), *parts[1:])) + "\n")
        yield from self.pictures

    def _cell(self, cell: Any) -> Iterator[str]:
        if cell.cell_type == "markdown":
            yield relink(cell.source, self.path)
            return
        yield f"```python\n{cell.source}\n```"
        for output in cell.outputs:
            yield self._output(output)

    def _output(self, output: Any) -> str:
        """HTML if there is any, else a picture, else text. Standard error is left out."""
        if output.output_type == "stream":
            return _text(output.text) if output.name == "stdout" else ""
        data = output.data
        if "text/html" in data:
            shown = _PICTURE.sub(lambda match: self._file(match.group(1)), _TAG_GAPS.sub(" ", data["text/html"]))
            return f'<div class="output">{shown}</div>'
        if "image/png" in data:
            name = self._file(data["image/png"])
            return f'<div class="output"><img src="{name}" alt="The plot that the cell above draws"></div>'
        return _text(data["text/plain"])

    def _file(self, encoded: str) -> str:
        name = f"{self.path.stem}-{len(self.pictures) + 1}.png"
        self.pictures.append(Page(f"notebooks/{name}", base64.b64decode(encoded)))
        return name


def _text(text: str) -> str:
    return f'<pre class="output"><code>{html.escape(text.rstrip()).replace(chr(10), "&#10;")}</code></pre>'
