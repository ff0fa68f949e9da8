"""The attackers run, and their runner reports what they find."""

import importlib
import os
import sys
from pathlib import Path

import pytest

import attack.__main__ as runner


@pytest.mark.parametrize("name", runner.ATTACKERS)
def test_a_seed_of_each_attacker(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if name in runner.NEED_TORCH:
        pytest.importorskip("torch")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    interval = sys.getswitchinterval()
    importlib.import_module(f"attack.{name}").attack(1)
    sys.setswitchinterval(interval)


@pytest.mark.parametrize(
    ("body", "report"),
    [
        ("pass", "seeds, nothing found"),
        ("assert seed < 7", "exit status 1 at seed 7. To see it again: python -m attack made_up --seed 7"),
        ("seed < 7 or os.abort()", "exit status -6 at seed 7."),
        ("seed < 7 or time.sleep(60)", "no answer for 1 s at seed 7."),
    ],
)
def test_the_runner_reports_findings(
    body: str, report: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "attack").mkdir()
    for module in ("__init__.py", "__main__.py"):
        (tmp_path / "attack" / module).write_text(Path(runner.__file__).with_name(module).read_text())
    program = f"import os, time\n\ndef attack(seed: int) -> None:\n    time.sleep(0.01)\n    {body}\n"
    (tmp_path / "attack" / "made_up.py").write_text(program)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.setattr(runner, "HANGS_AFTER", 1.0)
    assert runner.watch("made_up", 5, 3.0) == (body == "pass")
    assert report in capsys.readouterr().out
