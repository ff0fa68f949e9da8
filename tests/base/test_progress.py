"""Progress bars: more than was expected, and lines of a narrow terminal."""

import io

import pytest

from atari.base.progress import ProgressBar


def test_more_than_was_expected_is_all() -> None:
    with ProgressBar(total=10, file=io.StringIO()) as bar:
        bar.update(9)
        bar.update(4)
        assert (bar.n, bar.total) == (13, 13)


@pytest.mark.parametrize("columns", [50, 60, 64, 66, 70, 80, 120])
def test_no_word_is_cut_at_the_edge(columns: int) -> None:
    facts = {"unit": "step", "unit_scale": True, "rate": 17000.0, "ncols": columns}
    line = ProgressBar.format_meter(51200, 1e6, 30.0, postfix="no whole game yet", **facts)
    assert len(line) <= columns
    assert line.endswith(", no whole game yet]" if columns > 65 else "kstep/s]")


def test_seconds_of_one_game_have_no_blank() -> None:
    assert ProgressBar.format_meter(2, 10, 4.28, unit=" games", ncols=80).endswith("2.14s/game]")
    assert ProgressBar.format_meter(20, 50, 4.0, unit=" games", ncols=80).endswith("5.00 games/s]")


def test_it_follows_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    columns = [100]
    monkeypatch.setattr("tqdm.std._screen_shape_wrapper", lambda: lambda file: (columns[0], 24))
    with ProgressBar(total=10, file=(terminal := Terminal())) as bar:
        bar.refresh()
        columns[0] = 60
        bar.refresh()
        lines = terminal.getvalue().split("\r")
        assert len(lines[-1].rstrip()) <= 60 < len(lines[-2].rstrip())
