"""`atari.cores.verify` and `atari verify`: they find a difference, report it and replay it."""

import json
from pathlib import Path
from typing import Any

import pytest
from env_tools import needs_new_ale_py

from atari.cli import main
from atari.cores import NativeCore, PlainCore
from atari.cores.verify import VerificationRun, read, verify


@pytest.fixture
def broken_at_frame_20(monkeypatch: pytest.MonkeyPatch) -> None:
    """A native core that overwrites a byte of RAM in its 21st frame."""
    act = NativeCore.act

    def act_and_break(self: NativeCore, action: int, strength: float = 1.0) -> int:
        reward = act(self, action, strength)
        if self.frame_number == 21:
            self.set_ram(100, self.ram()[100] ^ 1)
        return reward

    monkeypatch.setattr(NativeCore, "act", act_and_break)


def test_equal_cores_have_no_difference() -> None:
    assert verify(VerificationRun("pong", frames=50)) is None
    assert verify(VerificationRun("pong", frames=50, cores=("native", "plain"))) is None


@pytest.mark.usefixtures("broken_at_frame_20")
def test_the_first_difference_is_named() -> None:
    difference = verify(VerificationRun("pong", frames=50, seed=3))
    assert difference is not None
    assert difference.frame == 20
    assert len(difference.what) == 1
    assert difference.what[0].startswith("ram in 1 bytes, first 100: ")
    assert str(difference).startswith(
        "pong: native differs from ale at frame 20 (seed 3, mode None, difficulty None): "
    )


@pytest.mark.usefixtures("broken_at_frame_20")
def test_a_difference_is_written_and_played_again(tmp_path: Path) -> None:
    difference = verify(VerificationRun("pong", frames=50, seed=3, pokes=True, strengths=True))
    assert difference is not None
    again = read(difference.write(tmp_path))
    assert again.frames == 21
    repeated = verify(again)
    assert repeated is not None
    assert (repeated.frame, repeated.what) == (difference.frame, difference.what)


@pytest.mark.parametrize(
    "content", ["", "{}", '{"run": {}, "frame": 1}', '{"run": {"nonsense": 1, "cores": []}, "frame": 0}']
)
def test_another_file_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "other.json").write_text(content)
    with pytest.raises(ValueError, match="is not a difference that `atari verify` wrote"):
        read(tmp_path / "other.json")


def test_actions_pokes_and_strengths_come_from_the_seed() -> None:
    run = VerificationRun("breakout", frames=300, seed=5, pokes=True, strengths=True)
    steps = list(run.steps())
    assert steps == list(run.steps())
    assert len({step.action for step in steps}) > 4
    assert any(step.poke for step in steps)
    assert len({step.strength for step in steps}) > 10
    assert steps != list(VerificationRun("breakout", frames=300, seed=6, pokes=True, strengths=True).steps())


SHOWN = "pong: Pong, as PongNoFrameskip-v0, but actions='full', max_num_frames_per_episode=None\n"


def test_the_command_plays_what_an_id_says(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    runs: list[VerificationRun] = []
    monkeypatch.setattr("atari.cli.verify._results", lambda found, jobs: runs.extend(found) or [])
    assert main(["verify", "PongNoFrameskip-v4", "ALE/Pong-v5", "pong", "--mode", "1"]) == 0
    assert [(run.repeat_action_probability, run.max_num_frames_per_episode, run.mode) for run in runs] == [
        (0.0, 108_000, 1),
        (0.25, 108_000, 1),
        (0.25, 0, 1),
    ]
    assert ", without actions='minimal', without frameskip=4\n" in capsys.readouterr().out


@needs_new_ale_py
def test_the_command_counts_runs_and_frames(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "pong", "breakout", "--frames", "20", "--seeds", "1", "2", "--jobs", "1"]) == 0
    assert (
        capsys.readouterr().out
        == SHOWN
        + SHOWN.replace("pong: Pong", "breakout: Breakout").replace("PongNo", "BreakoutNo")
        + "4 runs, 80 frames, 0 differences\n"
    )


@needs_new_ale_py
def test_the_command_plays_every_mode_and_difficulty(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "pong", "--frames", "5", "--modes", "--jobs", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"runs": 8, "frames": 40, "differences": []}


@needs_new_ale_py
@pytest.mark.usefixtures("broken_at_frame_20")
def test_the_command_reports_writes_and_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["verify", "pong", "--frames", "40", "--jobs", "1", "-o", str(tmp_path)]
    assert main(arguments) == 1
    out = capsys.readouterr().out
    assert "pong: native differs from ale at frame 20" in out
    assert "1 runs, 40 frames, 1 differences" in out
    (file,) = tmp_path.iterdir()
    assert main(["verify", "--replay", str(file), "--json"]) == 1
    reported: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert reported["differences"][0]["frame"] == 20


def test_the_command_compares_with_the_plain_core(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["verify", "pong", "--core", "plain", "--frames", "30", "--jobs", "1", "-o", str(tmp_path)]
    assert main(arguments) == 0
    assert capsys.readouterr().out == SHOWN + "1 runs, 30 frames, 0 differences\n"
    monkeypatch.setattr(PlainCore, "act", lambda self, action, strength=1.0: 7)
    assert main(arguments) == 1
    assert "pong: native differs from plain at frame 0" in capsys.readouterr().out


@needs_new_ale_py
def test_several_processes_give_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "pong", "enduro", "--frames", "20", "--jobs", "2"]) == 0
    assert capsys.readouterr().out.endswith("2 runs, 40 frames, 0 differences\n")


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["verify", "brekout"], 1, "did you mean 'breakout'?"),
        (["verify", "pong", "--modes", "--mode", "1"], 1, "--modes plays all of them; leave it or --mode out"),
        (["verify", "pong", "--intervention", "lazy_enemy"], 2, "has no place for --intervention, the field"),
        (["verify", "pong", "--seeds", "4294967296"], 2, "'4294967296' is not a whole number within 0..4294967295"),
        (["verify", "pong", "--frames", "0"], 2, "'0' is not a whole number within 1..1000000000"),
        (["verify", "pong", "--sticky", "2"], 2, "repeat_action_probability must be within 0..1"),
        (["verify", "--replay", "nowhere.json"], 1, "nowhere.json"),
        (["verify", "pong", "--core", "native"], 2, "invalid choice"),
    ],
)
def test_wrong_arguments(arguments: list[str], code: int, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == code
    assert text in capsys.readouterr().err
