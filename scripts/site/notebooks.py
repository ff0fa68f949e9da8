"""The pages of the notebooks of docs/notebooks/, with the outputs of a run that the build keeps in build/notebooks/."""

import base64
import hashlib
import html
import re
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from documents import ROOT
from nbclient import NotebookClient
from page import Page

import atari

FOLDER = ROOT / "docs" / "notebooks"
RUNS = ROOT / "build" / "notebooks"
_SECONDS = 300  # the most that a cell may take
_PICTURE = re.compile(r"data:image/png;base64,([A-Za-z0-9+/=]+)")
_TAG_GAPS = re.compile(r"\s*\n\s*")


def pages() -> Iterator[Page]:
    """A page of Markdown for each notebook, and its pictures as files."""
    for path in sorted(FOLDER.glob("*.ipynb")):
        yield from _Notebook(path).pages()


def run(path: Path) -> Any:
    """A notebook with the outputs of its cells; it runs only if it or the package has changed since the last time.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell has failed.
    """
    kept = RUNS / f"{path.stem}-{_version(path)}.ipynb"
    if not kept.exists():
        notebook = nbformat.read(path, as_version=4)
        with TemporaryDirectory() as folder:
            NotebookClient(notebook, timeout=_SECONDS, resources={"metadata": {"path": folder}}).execute()
        RUNS.mkdir(parents=True, exist_ok=True)
        for old in RUNS.glob(f"{path.stem}-*.ipynb"):
            old.unlink()
        nbformat.write(notebook, kept)
    return nbformat.read(kept, as_version=4)


def _version(path: Path) -> str:
    """A hash of the notebook and of the installed package."""
    package = Path(str(atari.__file__)).parent
    files = sorted(file for file in package.rglob("*") if file.suffix in (".py", ".so", ".pyd", ".toml"))
    found = hashlib.sha256(path.read_bytes())
    for file in files:
        found.update(file.read_bytes())
    return found.hexdigest()[:16]


class _Notebook:
    """A notebook as a page. Pictures in its outputs become files beside the page."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.pictures: list[Page] = []

    def pages(self) -> Iterator[Page]:
        parts = [part for cell in run(self.path).cells for part in self._cell(cell)]
        # After the title, which is the first line.
        title, _, rest = parts[0].partition("\n")
        link = f"[Download this notebook]({self.path.name}) to run it yourself."
        yield Page(f"notebooks/{self.path.stem}.md", "\n\n".join((title, link, rest.strip(), *parts[1:])) + "\n")
        yield from self.pictures

    def _cell(self, cell: Any) -> Iterator[str]:
        if cell.cell_type == "markdown":
            yield cell.source
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
