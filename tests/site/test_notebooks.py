"""The notebooks of docs/notebooks run, and are stored without outputs."""

import json
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
RUNS = {path.stem: path for path in NOTEBOOKS}


def test_there_are_three() -> None:
    assert set(RUNS) == {"pixels", "ram", "training"}


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
    for needed in ("nbclient", "ipykernel", "matplotlib", *(["torch"] if name == "training" else [])):
        pytest.importorskip(needed)
    notebook = site_module("notebook_runs").run(RUNS[name], tmp_path)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [output.data["text/html"] for output in outputs if "text/html" in output.get("data", {})]
    assert any("data:image/png" in page for page in shown)  # an environment or a replay shows itself
    assert not any(output.output_type == "stream" and output.name == "stderr" for output in outputs)
    assert list(tmp_path.iterdir()) == []
