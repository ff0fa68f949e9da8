"""`Search`: what each filter keeps, chains, undo, numbers, vectors, and the score of eight games found blind."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from env_tools import started

import atari
from atari.games.catalog import games
from atari.lab import Search
from atari.lab.search import recorded
from atari.recording import RecordReplay, Replay

ROWS = np.zeros((4, 128), np.uint8)
ROWS[:, 1] = [5, 6, 7, 8]
ROWS[:, 2] = [5, 4, 4, 9]
ROWS[:, 3] = [0x09, 0x10, 0x11, 0x99]
ROWS[:, 4] = [250, 251, 2, 3]


def find_score(game: str) -> Search:
    """Play at random, and search for the sum of the rewards."""
    env = started(game, obs_type="ram")
    env.action_space.seed(0)
    search, score, over = Search(env).bcd(0), 0.0, False
    while not over:
        _, reward, over, _, _ = env.step(env.action_space.sample())
        score += reward
        if reward:
            search.bcd(int(score))
    return search


@pytest.mark.parametrize(
    ("game", "found"),
    [
        ("asterix", "0xDF 0xE0 decimal"),
        ("asteroids", "0xBE decimal x 10"),
        ("atlantis", "0xA3 0xA2 0xA1 decimal"),
        ("beam_rider", "0x8A 0x89 decimal"),
        ("breakout", "0xCD decimal"),
        ("ms_pacman", "0xF9 0xF8 decimal"),
        ("qbert", "0xDA 0xDB decimal"),
        ("seaquest", "0xBA decimal"),
        ("space_invaders", "0xE8 decimal"),
        ("video_pinball", "0xB2 0xB0 decimal"),
    ],
)
def test_the_score_is_found_blind(game: str, found: str) -> None:
    search = find_score(game)
    assert [str(each) for each in search.places] == [found]
    labels = {label.index for label in games[game].ram_labels.values() if label.kind == "score"}
    assert set(search.candidates) <= labels  # which the search has not read


def test_each_filter_compares_with_the_ram_at_the_filter_before() -> None:
    search = Search(ROWS)
    assert search.seek(1).changed().candidates == [1, 2, 3, 4]
    assert search.seek(2).increased().candidates == [1, 3]
    assert search.seek(3).undo().increased().candidates == [1, 2, 3]
    assert search.equals(9).candidates == [2]


def test_the_filters_of_bytes() -> None:
    assert Search(ROWS).seek(1).unchanged().candidates == [0, *range(5, 128)]
    assert Search(ROWS).seek(1).decreased().candidates == [2]
    assert Search(ROWS).seek(2).decreased().candidates == [2, 4]
    assert Search(ROWS).between(5, 9).candidates == [1, 2, 3]
    assert Search(ROWS).equals(250).candidates == [4]


def test_a_series_up_or_down() -> None:
    assert Search(ROWS).correlates([0, 1, 2, 3]).candidates == [1]
    assert Search(ROWS).correlates([-10, -11, -12, -13], at_least=0.7).candidates == [1, 3, 4]


def test_a_series_of_a_game_that_is_played() -> None:
    env = started()
    search, ball = Search(env), [int(env.core.ram()[99])]
    for _ in range(40):
        env.step(env.action_space.sample())
        ball.append(int(env.core.ram()[99]))
        search.keep()
    assert 99 in search.correlates(ball).candidates
    with pytest.raises(ValueError, match="never changes"):
        search.correlates([1] * len(search.history))
    with pytest.raises(ValueError, match="a number for each state"):
        search.correlates([1, 2])


def test_numbers_grow_with_what_is_looked_for() -> None:
    rows = np.zeros((3, 128), np.uint8)
    rows[:, 10] = [0x90, 0x00, 0x34]
    rows[:, 11] = [0, 0x01, 0x12]
    search = Search(rows).bcd(90).seek(1).bcd(100).seek(2).bcd(1234)
    assert [str(each) for each in search.places] == ["0x8B 0x8A decimal"]
    assert search.candidates == [10, 11]
    assert search.increased().emptied_by == "increased(), filter 4 of 4, left none of 1"


def test_zeros_at_the_end_need_not_be_in_ram() -> None:
    rows = np.zeros((1, 128), np.uint8)
    rows[0, 7] = 0x12
    assert "0x87 decimal x 100" in [str(each) for each in Search(rows).bcd(1200).places]


def test_a_number_in_given_bytes() -> None:
    rows = np.zeros((2, 128), np.uint8)
    rows[:, [3, 60]] = [[0x34, 0x12], [0x35, 0x12]]
    search = Search(rows).bcd(1234, bytes=[0x83, 60]).seek(1).increased().bcd(1235)
    assert [each.bytes for each in search.places] == [(3, 60)]


def test_undo_takes_the_last_filter_back() -> None:
    search = Search(ROWS).seek(1).changed().seek(2).bcd(11)
    assert search.candidates == [3]
    assert search.undo().candidates == [1, 2, 3, 4]
    assert [each.call for each in search.filters] == ["changed()"]
    assert len(search.undo().candidates) == 128
    with pytest.raises(ValueError, match="no filter to undo"):
        search.undo()


def test_an_empty_result_names_the_filter() -> None:
    search = Search(ROWS).equals(5).equals(77).unchanged()
    assert search.candidates == []
    assert search.emptied_by == "equals(77), filter 2 of 3, left none of 2"
    assert search.emptied_by in repr(search)
    assert "equals(77), filter 2 of 3" in str(search.table())
    assert "equals(77), filter 2 of 3" in search._repr_html_()
    assert search.undo().undo().candidates == [1, 2]


def test_the_table_has_histories_and_labels() -> None:
    env = started()
    search = Search(env).equals(5)
    text = str(search.table())
    assert "0xB9" in text
    assert "lives" in text
    assert "<table>" in search._repr_html_()
    wide = Search(ROWS).seek(3).correlates([5, 6, 7, 8])
    assert str(wide.table()).splitlines()[1].split() == ["0x81", "1", "5", "6", "7", "8"]


def test_in_a_vector_all_games_must_fit() -> None:
    envs = atari.AtariVectorEnv("breakout", 3, obs_type="ram")
    envs.reset(seed=0)
    search, one = Search(envs), Search(envs, index=1)
    lives = [lane.lives for lane in envs.lanes]
    assert 57 in search.equals(lives).candidates
    assert 57 in one.equals(lives[1]).candidates
    assert set(search.candidates) <= set(one.candidates)
    assert search.history.shape == (2, 3, 128)
    assert one.history.shape == (2, 128)
    with pytest.raises(IndexError, match="3"):
        Search(envs, index=3)
    with pytest.raises(ValueError, match=r"shape \(3,\)"):
        search.equals([1, 2])
    envs.close()


def test_cores_and_wrapped_environments() -> None:
    env = started()
    assert Search(env.core).equals(5).candidates == Search(atari.wrappers.ClipReward(env)).equals(5).candidates
    env.driver.make_sound()  # replaces the core
    assert 57 in Search(env).equals(5).candidates


@pytest.mark.parametrize(
    ("use", "error", "text"),
    [
        (lambda search: search.equals("5"), TypeError, "n must be an integer"),
        (lambda search: search.equals(1.5), TypeError, "n must be an integer"),
        (lambda search: search.between(4, 2), ValueError, "a <= b"),
        (lambda search: search.bcd(-1), ValueError, "0 or more"),
        (lambda search: search.bcd(10**15), ValueError, "at most"),
        (lambda search: search.bcd(1, bytes=[0x100]), ValueError, "index 0..127"),
        (lambda search: search.bcd(1, bytes=[]), ValueError, "at least one"),
        (lambda search: search.correlates([1, 2, 3, float("nan")]), ValueError, "finite"),
        (lambda search: search.correlates([1, 2, 3, 4], at_least=2), ValueError, "0..1"),
        (lambda search: search.correlates("abcd"), TypeError, "numbers"),
        (lambda search: search.seek(4), ValueError, "state"),
        (lambda search: search.keep(), ValueError, "recorded history"),
        (lambda search: search.undo(), ValueError, "no filter"),
    ],
)
def test_what_is_refused_changes_nothing(use: object, error: type[Exception], text: str) -> None:
    search = Search(ROWS)
    with pytest.raises(error, match=text):
        use(search)  # type: ignore[operator]
    assert len(search.candidates) == 128
    assert not search.filters


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: Search("pong"), TypeError, r"take an environment, such as atari.make\('pong'\), or a recorded game"),
        (lambda: Search(5), TypeError, "AtariVectorEnv"),
        (lambda: Search(started(), index=0), TypeError, "leave it out"),
        (lambda: Search(np.zeros((0, 128), np.uint8)), ValueError, "a recorded history needs"),
        (lambda: Search(started()).seek(0), ValueError, "a game that is played"),
        (lambda: Search(np.zeros((3, 127), np.uint8)), ValueError, "history of RAM"),
        (lambda: Search(np.zeros(128, np.uint8)), ValueError, "history of RAM"),
        (lambda: Search(np.zeros((3, 128))), TypeError, "history of RAM"),
        (lambda: Search(np.full((3, 128), 256)), TypeError, "history of RAM"),
        (lambda: Search(np.zeros((3, 2, 128), np.uint8), index=2), IndexError, r"no game 2 .* has 0\.\.1"),
    ],
)
def test_a_source_without_ram_is_refused(make: Callable[[], Search], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        make()


def test_a_series_of_numbers_in_a_long_history() -> None:
    rng = np.random.default_rng(0)
    numbers = rng.integers(10_000, size=50_000)
    rows = rng.integers(256, size=(len(numbers), 128), dtype=np.uint8)
    rows[:, 40] = numbers % 100 // 10 * 16 + numbers % 10
    rows[:, 41] = numbers // 1000 * 16 + numbers // 100 % 10
    search = Search(rows).bcd(int(numbers[0])).correlates(numbers, at_least=0.99)
    assert [str(each) for each in search.places] == ["0xA9 0xA8 decimal"]


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


def test_a_file_that_is_no_replay(tmp_path: Path) -> None:
    (tmp_path / "a.a26r").write_bytes(b"no")
    with pytest.raises(ValueError, match="replay"):
        Search(tmp_path / "a.a26r")
    with pytest.raises(FileNotFoundError):
        Search(tmp_path / "b.a26r")
