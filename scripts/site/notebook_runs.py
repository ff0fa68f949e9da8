"""Runs of notebooks, kept in build/notebooks/. Both the tests and the site need one: the first runs it for both."""

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient

import atari

RUNS = Path(__file__).parents[2] / "build" / "notebooks"
SHORT: Mapping[str, Mapping[str, int]] = {"lecture-2": {"STEPS": 20_000}}
"""The values of lines `NAME = VALUE` in the runs for the site, by notebook: its training takes minutes."""
_SECONDS = 300  # the most that a cell may take in such a run


def kept_run(path: Path) -> Any:
    """A notebook with the outputs of its cells; it runs only if it or the package has changed since the last time.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell has failed.
    """
    kept = _kept(path)
    if not kept.exists():
        with TemporaryDirectory() as folder:
            run(path, Path(folder))
    return nbformat.read(kept, as_version=4)


def run(path: Path, folder: Path) -> Any:
    """A notebook with the outputs of its cells, which run in a folder. The outputs are kept for the site."""
    notebook = run_with(path, folder, SHORT.get(path.stem, {}), _SECONDS)
    RUNS.mkdir(parents=True, exist_ok=True)
    for old in RUNS.glob(f"{path.stem}-*.ipynb"):
        old.unlink()
    nbformat.write(notebook, _kept(path))
    return notebook


def run_with(path: Path, folder: Path, values: Mapping[str, int], seconds: int, last: str = "") -> Any:
    """A notebook with the outputs of its cells, which run in a folder.

    Args:
        path: the notebook.
        folder: the working directory of its cells.
        values: other values of lines `NAME = VALUE`.
        seconds: the most that a cell may take.
        last: a cell that runs after the others.

    Raises:
        ValueError: the notebook has no such line, or several.
        nbclient.exceptions.CellExecutionError: a cell has failed.
    """
    notebook = nbformat.read(path, as_version=4)
    if last:
        notebook.cells.append(nbformat.v4.new_code_cell(last))
    sources = [cell.source for cell in notebook.cells]
    for name, value in values.items():
        line = re.compile(rf"^{name} = .*$", re.M)
        if (found := sum(len(line.findall(source)) for source in sources)) != 1:
            raise ValueError(f"{path} has {found} lines {name} = ..., and one is replaced")
        for cell in notebook.cells:
            cell.source = line.sub(f"{name} = {value}", cell.source)
    NotebookClient(notebook, timeout=seconds, resources={"metadata": {"path": str(folder)}}).execute()
    for cell, source in zip(notebook.cells, sources, strict=True):
        cell.source = source
    return notebook


def _kept(path: Path) -> Path:
    return RUNS / f"{path.stem}-{_version(path)}.ipynb"


def _version(path: Path) -> str:
    """A hash of the notebook and of the installed package."""
    package = Path(str(atari.__file__)).parent
    files = sorted(file for file in package.rglob("*") if file.suffix in (".py", ".so", ".pyd", ".toml"))
    found = hashlib.sha256(path.read_bytes())
    for file in files:
        found.update(file.read_bytes())
    return found.hexdigest()[:16]
