"""Folders of policies: what is loaded of strangers' files, and what is left out with a reason."""

import hashlib
import json
import shutil
from pathlib import Path

import pytest

pytest.importorskip("torch")

from atari.learning import RunFolder
from atari.learning.policy_folder import is_policy_folder, policies_in
from atari.policy import LoadedPolicy

EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAM = "raise SystemExit('executed')\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a policy, of a user who trusts no program."""
    monkeypatch.setattr("atari.learning.programs.user_data_path", lambda *_, **__: tmp_path / "data")
    made = tmp_path / "policies"
    shutil.copytree(EXAMPLES / "breakout-pqn", made / "good")
    return made


def with_program(folder: Path, kind: str) -> RunFolder:
    """A run folder with a program of its own."""
    run = folder / f"own-{kind}"
    shutil.copytree(EXAMPLES / "breakout-pqn", run)
    (run / f"{kind}.py").write_text(PROGRAM)
    config = json.loads((run / "config.json").read_text())
    entry = {"file": f"{kind}.py", "name": "Mine", "sha256": hashlib.sha256(PROGRAM.encode()).hexdigest()}
    (run / "config.json").write_text(json.dumps({**config, "programs": {kind: entry}}))
    return RunFolder.open(run)


def test_a_run_folder_is_no_folder_of_policies(folder: Path) -> None:
    assert is_policy_folder(str(folder))
    assert not is_policy_folder(str(folder / "good"))
    assert not is_policy_folder("random")


def test_broken_entries_do_not_stop_the_others(folder: Path) -> None:
    (folder / "broken").mkdir()
    (folder / "broken" / "config.json").write_text("{}")
    (folder / "damaged.onnx").write_bytes(b"no model")
    (folder / "README.md").write_text("about")
    (folder / "empty").mkdir()
    found = dict(policies_in(folder))
    assert list(found) == ["broken", "damaged.onnx", "good"]
    assert isinstance(found["good"], LoadedPolicy)
    assert "has format None" in str(found["broken"])
    assert isinstance(found["damaged.onnx"], str)


@pytest.mark.parametrize("kind", ["agent", "network"])
def test_a_program_is_loaded_only_if_it_is_trusted(folder: Path, kind: str) -> None:
    run = with_program(folder, kind)
    reason = dict(policies_in(folder))[f"own-{kind}"]
    assert isinstance(reason, str)
    assert f"{kind}.py is a program, which loading the run executes" in reason
    run.trust()
    reason = dict(policies_in(folder))[f"own-{kind}"]
    assert "executed" in str(reason)  # it is executed now, and ends


def test_files_that_may_be_programs_are_not_loaded(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "model.zip").write_bytes(b"PK")
    (folder / "script.pt").write_bytes(b"PK")
    loaded: list[Path] = []
    monkeypatch.setattr("atari.learning.policy_folder.load_policy", lambda source, **_: loaded.append(source))
    found = dict(policies_in(folder))
    assert loaded == [folder / "good"]
    for name in ("model.zip", "script.pt"):
        assert f"if you trust its author, name it by itself: {folder / name}" in str(found[name])


def test_a_folder_without_policies_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="has no policies: no run folders and no files"):
        list(policies_in(tmp_path))
