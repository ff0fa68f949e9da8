"""Runs of notebooks, kept in build/notebooks/. Both the tests and the site need one: the first runs it for both."""

import hashlib
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient

import atari

RUNS = Path(__file__).parents[2] / "build" / "notebooks"
_SECONDS = 300  # the most that a cell may take


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
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=_SECONDS, resources={"metadata": {"path": str(folder)}}).execute()
    RUNS.mkdir(parents=True, exist_ok=True)
    for old in RUNS.glob(f"{path.stem}-*.ipynb"):
        old.unlink()
    nbformat.write(notebook, _kept(path))
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
