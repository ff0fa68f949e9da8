"""Notebooks: the code cells change, and outputs, texts and lines for IPython stay."""

import json
from pathlib import Path
from typing import Any

import pytest
from old_scripts import run

from atari.classic.__main__ import main
from atari.classic.rewrite import modernized
from atari.classic.rewrite.notebook import Notebook

nbformat = pytest.importorskip("nbformat")

CELLS = [
    "%matplotlib inline\nimport gym\nimport numpy as np\n!pip list | grep {name}\nfiles = !ls",
    "env = gym.make('CartPole-v1')\nenv.seed(0)\nif True:\n    !echo ü\nstate = env.reset()",
    "%%time\nstate, reward, done, info = env.step(0)\nprint('%d'\n      % 3)",
    "%%bash\nimport gym",
    "env?",
    "%timeit env.reset()\nx = np.float(1)",
]


def notebook(cells: list[str], **options: Any) -> str:
    made = nbformat.v4.new_notebook(metadata={"kernelspec": {"display_name": "Pythön", "name": "python3"}})
    made.cells = [nbformat.v4.new_markdown_cell("import gym  # a text")]
    for number, cell in enumerate(cells):
        output = nbformat.v4.new_output("stream", text=f"output {number}\n")
        made.cells.append(nbformat.v4.new_code_cell(cell, outputs=[output], execution_count=number))
    return nbformat.writes(made, **options) + "\n"


def code(text: str) -> list[str]:
    return [cell.source for cell in nbformat.reads(text, 4).cells if cell.cell_type == "code"]


def rewritten(text: str) -> str:
    old = Notebook(text)
    return old.result(modernized(old.script))


def test_cells_are_one_script() -> None:
    old = notebook(CELLS)
    new = rewritten(old)
    assert code(new) == [
        "%matplotlib inline\nimport gymnasium as gym\nimport numpy as np\n!pip list | grep {name}\nfiles = !ls",
        "env = gym.make('CartPole-v1')\nenv.reset(seed=0)\nif True:\n    !echo ü\nstate, _ = env.reset()",
        "%%time\nstate, reward, terminated, truncated, info = env.step(0)\ndone = terminated or truncated\nprint('%d'\n      % 3)",
        "%%bash\nimport gym",
        "env?",
        "%timeit env.reset()\nx = float(1)",
    ]
    assert rewritten(new) == new


def test_everything_else_stays() -> None:
    old = notebook(CELLS)
    before, after = json.loads(old), json.loads(rewritten(old))
    for cell in [*before["cells"], *after["cells"]]:
        if cell["cell_type"] == "code":
            del cell["source"]
    assert before == after
    changed = [line for line in rewritten(old).split("\n") if line not in old.split("\n")]
    assert len(changed) == 6  # the other lines of the file are equal, with their indentation and order


def test_a_notebook_without_gym_stays() -> None:
    text = json.dumps(json.loads(notebook(["x = 1"])), indent=3)
    assert rewritten(text) == text


def test_the_result_runs() -> None:
    new = rewritten(
        notebook([CELLS[0].split("\n")[1], CELLS[1].replace("    !echo ü", "    pass"), "s, r, done, i = env.step(1)"])
    )
    assert run("\n".join(code(new)))["done"] is False


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "course.ipynb"
    old = notebook(CELLS)
    path.write_text(old, encoding="utf-8")
    assert main(["--modern", str(path), "--write"]) == 0
    printed = capsys.readouterr().out
    assert " # cell 2\n %matplotlib inline\n-import gym\n+import gymnasium as gym\n" in printed
    assert "output" not in printed
    assert (tmp_path / "course.ipynb.orig").read_text(encoding="utf-8") == old
    assert "import gymnasium" in path.read_text(encoding="utf-8")


def test_marks_stand_in_their_cell() -> None:
    new = code(rewritten(notebook([CELLS[0], "env = gym.make('CartPole-v1')", "*a, = env.step(0)"])))
    assert new[2].startswith("# atari.classic: step() returns five values now")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "it is not JSON, as notebooks are (Expecting value: line 1 column 1 (char 0)); it may be damaged"),
        ("import gym", "it is not JSON"),
        ("[]", "it is JSON, but not a notebook"),
        ("{}", "it is JSON, but not a notebook"),
        ('{"worksheets": []}', "it is not a notebook of version 4"),
        ('{"cells": [1]}', "it is not a notebook of version 4"),
    ],
)
def test_other_files(text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.ipynb"
    path.write_text(text)
    assert main(["--modern", str(path)]) == 1
    assert said in capsys.readouterr().err
    path.write_text(notebook(["import gym\nprint 3"]))
    assert main(["--modern", str(path)]) == 1
    assert "this is Python 2" in capsys.readouterr().err
