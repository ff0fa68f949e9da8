"""`examples/breakout-pqn` and its like: the policies of the trainings of 200 million frames."""

from pathlib import Path

import pytest

pytest.importorskip("torch")

from atari.cli import main
from atari.learning import RunFolder, compare, evaluate, load_policy

FOLDER = Path(__file__).parents[2] / "examples" / "breakout-pqn"


@pytest.mark.parametrize(
    ("game", "least", "frames"),
    [  # the means of 100 games are 166, 1,196 and 8,078; a random policy has 1, 148 and 164
        ("breakout", 60, 200_015_872),
        ("space_invaders", 600, 199_000_064),
        ("qbert", 7_900, 199_000_064),
    ],
)
def test_they_play_as_the_page_says(game: str, least: float, frames: int) -> None:
    folder = FOLDER.with_name(f"{game}-pqn")
    result = evaluate(load_policy(folder), game, "dopamine", episodes=2)
    assert result[game].mean > least
    assert result.training_frames == RunFolder.open(folder).rows()[-1]["frames"] == frames
    assert (folder / "policy.pt").stat().st_size < 1_000_000
    if game != "breakout":  # its training goes beyond the last score of the published agent
        assert compare(result, "dopamine/rainbow").rows[1].runs == 5  # the scores of seeds at the end


def test_it_plays_another_game_with_a_note(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["evaluate", str(FOLDER), "--protocol", "dopamine", "--print-task"]
    assert main([*command, "pong"]) == 0
    assert capsys.readouterr().err.endswith("breakout-pqn) was trained on breakout, and plays pong\n")
    assert main([*command, "breakout"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "words", [["record", "pong", "--seconds", "1", "--policy", str(FOLDER)], ["watch", str(FOLDER), "pong"]]
)
def test_what_it_cannot_play_is_refused_with_the_game_of_its_training(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 1
    error = capsys.readouterr().err
    assert "breakout-pqn) was trained on breakout, and pong is another game: " in error
    assert "note" not in error
