"""Recorded histories: replays, arrays, vectors."""

from pathlib import Path

import numpy as np
import pytest

import atari
from atari.lab import Search
from atari.lab.search import recorded
from atari.recording import RecordReplay, Replay


def record(path: Path, steps: int) -> np.ndarray:
    """Record a game and return the RAM after each frame."""
    env = RecordReplay(atari.AtariEnv("breakout", frameskip=2, obs_type="ram"), path)
    env.reset(seed=0)
    env.action_space.seed(0)
    rows = []
    for _ in range(steps):
        rows.append(env.step(env.action_space.sample())[0])
    env.close()
    return np.stack(rows)


def test_a_replay_has_a_state_after_each_frame(tmp_path: Path) -> None:
    path = tmp_path / "a.a26r"
    rows = record(path, 30)
    for source in (path, str(path), Replay.load(path)):
        states = recorded(source)
        assert states is not None
        assert states.shape == (60, 1, 128)
        assert np.array_equal(states[1::2, 0], rows)
    search = Search(path).seek(59).correlates(rows.repeat(2, axis=0)[:, 99], at_least=0.9)
    assert 99 in search.candidates


def test_arrays_of_one_game_and_of_many() -> None:
    rows = np.random.default_rng(0).integers(256, size=(5, 3, 128))
    assert Search(rows).history.shape == (5, 3, 128)
    one = Search(rows, index=2)
    assert np.array_equal(one.history, rows[:, 2])
    assert one.equals(rows[0, 2, 17]).candidates.count(17) == 1
    assert Search(rows).equals(rows[0, :, 17]).candidates == [17]
    assert Search(rows).correlates(rows[:, :, 40]).candidates == [40]
    assert Search(rows[:, 0].tolist()).history.dtype == np.uint8


@pytest.mark.parametrize(
    ("array", "error"),
    [
        (np.zeros((3, 127), np.uint8), ValueError),
        (np.zeros(128, np.uint8), ValueError),
        (np.zeros((3, 128)), TypeError),
        (np.full((3, 128), 256), TypeError),
    ],
)
def test_other_arrays_are_refused(array: np.ndarray, error: type[Exception]) -> None:
    with pytest.raises(error, match="history of RAM"):
        Search(array)


def test_a_file_that_is_no_replay(tmp_path: Path) -> None:
    (tmp_path / "a.a26r").write_bytes(b"no")
    with pytest.raises(ValueError, match="replay"):
        Search(tmp_path / "a.a26r")
    with pytest.raises(FileNotFoundError):
        Search(tmp_path / "b.a26r")
