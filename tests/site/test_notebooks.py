"""The notebooks of docs/notebooks run, and are stored without outputs."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
RUNS = {path.stem: path for path in NOTEBOOKS}
COUNTED = {"7 tasks, 5 games of each: 35 games\n"}
"""Lines on stderr: `evaluate` prints the number of games of variants."""


LEARN = {"lecture-1": ["av"], "lecture-2": ["torch", "av"], "pixels": [], "ram": [], "training": ["torch"]}
"""The packages that the notebooks need, beside those of every notebook."""


def test_each_notebook_is_here() -> None:
    assert set(RUNS) == set(LEARN)


@pytest.mark.parametrize("name", RUNS)
def test_outputs_are_not_stored(name: str) -> None:
    notebook = json.loads(RUNS[name].read_text(encoding="utf-8"))
    for cell in notebook["cells"]:
        assert cell["metadata"] == {}
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None
    assert notebook["cells"][0]["source"][0].startswith("# ")
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    assert RUNS[name].stat().st_size < 20_000


@pytest.mark.parametrize("name", RUNS)
def test_it_runs(name: str, tmp_path: Path, site_module: Callable[[str], ModuleType]) -> None:
    for needed in ("nbclient", "ipykernel", "matplotlib", *LEARN[name]):
        pytest.importorskip(needed)
    notebook = site_module("notebook_runs").run(RUNS[name], tmp_path)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    kinds = ("data:image/png", "data:video/mp4")
    assert any(kind in page for page in shown for kind in kinds)  # an environment or a replay shows itself
    assert {output.text for output in outputs if output.output_type == "stream" and output.name == "stderr"} <= COUNTED
    assert list(tmp_path.iterdir()) == []
    if name == "lecture-2":
        check_lecture(outputs)


def check_lecture(outputs: list[Any]) -> None:
    """The short training has finite losses. scripts/generate/lecture.py checks that the whole one learns."""
    printed = "".join(output.text for output in outputs if output.output_type == "stream")
    found = re.search(r"([\d,]+) updates\nmean of the last 500 losses: ([\d.]+)", printed)
    assert found
    assert int(found[1].replace(",", "")) == (20_000 - 5_000) // 16  # an update a step of 16 lanes, after 5,000
    assert 0 < float(found[2]) < 1
    assert len(re.findall(r"^intervention=\w+ +5 ", printed, re.M)) == 6
    (curve,) = (output for output in outputs if "800x320" in output.get("data", {}).get("text/plain", ""))
    assert "image/png" in curve.data  # the picture that grows is one output


def test_a_run_with_another_value_needs_one_such_line(tmp_path: Path, site_module: Callable[[str], ModuleType]) -> None:
    pytest.importorskip("nbclient")
    runs = site_module("notebook_runs")
    for name in ("NOTHING", "ram"):  # lecture-2 sets `ram` within lines alone
        with pytest.raises(ValueError, match=rf"lecture-2.ipynb has 0 lines {name} = \.\.\., and one is replaced"):
            runs.run_with(RUNS["lecture-2"], tmp_path, {name: 1}, 10)


def test_links_between_notebooks_are_links_between_pages() -> None:
    """In a process of its own: `documents` is a module of the tests, too."""
    program = (
        "import sys, nbformat, pathlib\nsys.path.insert(0, sys.argv[1])\nfrom documents import relink\n"
        "path = pathlib.Path(sys.argv[2])\nfor cell in nbformat.read(path, 4).cells:\n    print(relink(cell.source, path))"
    )
    pytest.importorskip("nbformat")
    command = [sys.executable, "-c", program, str(FOLDER.parents[1] / "scripts/site")]
    for name, link in (("lecture-1", "[Part 2](lecture-2.md)"), ("ram", "[The RAM lab](../ram.md)")):
        assert link in subprocess.run([*command, str(RUNS[name])], check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("name", ["lecture-1", "lecture-2"])
def test_the_lecture_can_be_handed_out_without_the_documentation(name: str) -> None:
    assert "](../" not in RUNS[name].read_text(encoding="utf-8")
