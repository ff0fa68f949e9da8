"""The log of a training: its last row, while the training writes."""

from pathlib import Path

from atari.learning.run_log import read_last_row


def test_the_last_row_of_a_log_that_is_being_written(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    assert read_last_row(file) == {}
    for text, row in [
        ("", {}),
        ("step,loss\n", {}),
        ("step,loss\n1,0.5\n", {"step": 1.0, "loss": 0.5}),
        ("step,loss\n1,0.5\n2,0.", {"step": 1.0, "loss": 0.5}),
        ("step,loss\n1,0.5\n2,x\n", {}),
        ("step,loss\n" + "1,0.5\n" * 5000 + "7,0.25\n", {"step": 7.0, "loss": 0.25}),
    ]:
        file.write_text(text)
        assert read_last_row(file) == row
