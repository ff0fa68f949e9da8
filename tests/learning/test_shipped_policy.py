"""`examples/breakout-pqn`: the policy of the training of 200 million frames."""

from pathlib import Path

import pytest

pytest.importorskip("torch")

from atari.cli import main
from atari.learning import RunFolder, evaluate, load_policy

FOLDER = Path(__file__).parents[2] / "examples" / "breakout-pqn"


def test_it_plays_as_the_page_says() -> None:
    result = evaluate(load_policy(FOLDER), "breakout", "dopamine", episodes=4)
    assert result["breakout"].mean > 60  # 166 over 100 games; a random policy has 1.2
    assert result.training_frames == RunFolder.open(FOLDER).rows()[-1]["frames"] == 200_015_872


def test_it_is_small() -> None:
    assert (FOLDER / "policy.pt").stat().st_size < 1_000_000


def test_it_plays_another_game_with_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["evaluate", str(FOLDER), "--protocol", "dopamine", "--print-task"]
    assert main([*command, "pong"]) == 0
    assert capsys.readouterr().err.endswith("breakout-pqn) was trained on breakout, and plays pong\n")
    assert main([*command, "breakout"]) == 0
    assert capsys.readouterr().err == ""
