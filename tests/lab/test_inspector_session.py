"""The inspector's session, without a page: playing, going back, changing RAM, forks, search."""

import numpy as np
import pytest
from inspector_tools import LIVES, PADDLE, SCORE, Sweeper, new_session, play
from numpy.testing import assert_array_equal

import atari._emulator as _emulator
from atari.env import AtariEnv
from atari.games.actions import Action
from atari.lab.inspector import timeline
from atari.lab.inspector.session import Session


def test_time_plays_frames_at_the_speed_of_the_console() -> None:
    session = new_session()
    session.tick(1.0)
    assert session.at == 0  # paused
    session.play()
    session.tick(0.1)
    assert session.at == 6
    session.set_speed(4.0)
    session.tick(0.1)
    assert session.at == 30
    session.tick(100)  # the page slept; the lost time is dropped
    assert session.at == 90
    with pytest.raises(ValueError, match="speed is one of"):
        session.set_speed(3.0)


def test_going_back_gives_the_same_bytes() -> None:
    session = new_session()
    seen = []
    for _ in range(200):
        play(session, 1)
        seen.append((session.ram(), session.main.core.screen(), session.main.score))
    for frame in (200, 1, 31, 30, 29, 150, 151, 91):
        session.seek(frame)
        assert session.at == frame
        assert session.main.end == 200
        ram, screen, score = seen[frame - 1]
        assert_array_equal(session.ram(), ram)
        assert_array_equal(session.main.core.screen(), screen)
        assert session.main.score == score
        assert_array_equal(session.main.ram_at(frame), ram)
    session.seek(10**6)
    assert session.at == 200
    session.seek(100)
    session.step(5)  # follows what was recorded
    assert_array_equal(session.ram(), seen[104][0])


def test_a_key_takes_over_what_was_recorded() -> None:
    session = new_session()
    play(session, 100)
    session.seek(50)
    session.hold(0, 0, False)
    assert session.main.end == 100
    session.hold(0, 1, False)
    assert (session.main.end, session.by_agent, session.action) == (50, False, Action.RIGHT)
    before = session.ram()[PADDLE]
    session.step(10)
    assert (session.main.end, session.at) == (60, 60)
    session.hold(0, 1, False)
    session.playing = True
    session.tick(0.2)
    assert session.ram()[PADDLE] > before


def test_a_press_while_paused_says_so() -> None:
    session = new_session()
    session.hold(0, 0, False)
    assert session.notice == ""
    session.hold(0, 0, True)
    assert session.notice == "the game is paused; Play (P) goes on"
    play(session, 100)
    session.seek(40)
    session.hold(0, 0, True)
    assert session.notice.endswith("; the 60 frames recorded after this one were dropped")
    session.notice = ""
    session.play()
    session.hold(0, 1, False)
    assert session.notice == ""


def test_the_oldest_frames_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timeline, "MOST_FRAMES", 900)
    session = new_session("pong")
    rams = []
    for _ in range(1300):
        play(session, 1)
        rams.append(session.ram())
    assert (session.main.first, session.main.end) == (600, 1300)
    for frame in (600, 601, 777, 1299):
        session.seek(frame)
        assert_array_equal(session.ram(), rams[frame - 1])
    session.seek(0)
    assert session.at == 600


def test_a_poke_is_seen_before_a_frame_is_played_and_can_be_undone() -> None:
    session = new_session()
    play(session, 60)
    before, screen = session.ram(), session.screen(session.main)[0]
    session.poke(PADDLE, 60)
    shown, preview = session.screen(session.main)
    assert preview
    assert (shown != screen).any()
    assert session.ram()[PADDLE] == 60
    assert session.at == 60
    session.undo()
    assert_array_equal(session.ram(), before)
    assert not session.screen(session.main)[1]
    session.poke(0x80 + LIVES, 3)  # an address
    session.step()
    assert session.ram()[LIVES] == 3
    session.undo()
    assert session.ram()[LIVES] == before[LIVES]
    assert "was written back" in session.notice
    with pytest.raises(ValueError, match="no change of RAM to undo"):
        session.undo()


def test_a_poke_in_the_past_drops_the_future_and_is_part_of_it() -> None:
    session = new_session()
    play(session, 90)
    session.seek(40)
    session.poke(LIVES, 2)
    play(session, 20)
    after = session.ram()
    session.seek(10)
    session.seek(60)
    assert_array_equal(session.ram(), after)
    assert after[LIVES] == 2


def test_frozen_bytes_hold_at_every_frame() -> None:
    session = new_session()
    session.freeze(LIVES, 5)
    session.freeze(PADDLE)
    held = session.ram()[PADDLE]
    play(session, 400)
    rams = np.stack([session.main.ram_at(frame) for frame in range(1, 401)])
    assert (rams[:, LIVES] == 5).all()
    assert (rams[:, PADDLE] == held).all()
    session.release(LIVES)
    session.release(PADDLE)
    play(session, 300)
    assert session.ram()[LIVES] < 5
    session.undo()
    assert session.frozen == {PADDLE: held}


def test_frozen_lives_are_never_seen_lost_by_the_rules() -> None:
    session = new_session()
    session.freeze(LIVES, 1)
    play(session, 900)
    assert session.main.core.lives == 1
    assert not session.over
    seen = session.ram()
    session.seek(400)
    session.seek(900)
    assert_array_equal(session.ram(), seen)
    loser = new_session()
    loser.poke(LIVES, 1)
    play(loser, 300)
    assert loser.main.core.lives == 0


def test_a_freeze_of_the_game_and_one_of_its_fork_are_apart() -> None:
    session = new_session()
    session.freeze(LIVES, 3)
    play(session, 20)
    session.open_fork()
    session.freeze(PADDLE, 60)
    session.release(LIVES)
    session.poke(LIVES, 2)
    play(session, 20)
    assert session.fork is not None
    assert (session.main.core.ram()[LIVES], session.fork.core.ram()[LIVES]) == (3, 2)
    assert session.fork.core.ram()[PADDLE] == 60 != session.main.core.ram()[PADDLE]
    session.close_fork()
    assert session.frozen == {LIVES: 3}
    assert len(session.changes) == 1
    session.undo()
    assert session.frozen == {}
    session.open_fork()
    session.freeze(PADDLE, 60)
    session.close_fork(keep=True)
    play(session, 5)
    assert session.frozen == {PADDLE: 60}
    assert session.ram()[PADDLE] == 60


def test_a_release_ends_it_on_the_core_at_once() -> None:
    session = new_session()
    session.freeze(PADDLE, 60)
    session.step(3)
    session.release(PADDLE)
    env = session.env
    for _ in range(5):
        env.step(int(Action.RIGHT))
    assert env.core.ram()[PADDLE] != 60


def test_at_most_64_bytes_are_held() -> None:
    session = new_session()
    for index in range(64):
        session.freeze(index)
    with pytest.raises(ValueError, match="at most 64 writes"):
        session.freeze(64)
    assert len(session.frozen) == len(session.changes) == 64


def test_a_preview_is_what_redraw_draws() -> None:
    """`Session` shows it as palette indices, which the page draws; `redraw` gives colours."""
    for game in ("breakout", "pong", "seaquest"):
        session = new_session(game)
        session.step(120)
        session.poke(PADDLE, 60)
        shown, preview = session.screen(session.main)
        assert preview
        colours = _emulator.palette(session.game.screen.format)[shown]
        assert_array_equal(colours, session.main.core.redraw())


def test_a_fork_plays_beside_the_game() -> None:
    session = new_session()
    play(session, 80)
    session.open_fork()
    assert session.fork is not None
    session.poke(LIVES, 1)
    assert session.main.core.ram()[LIVES] == 5
    assert session.ram()[LIVES] == 1
    play(session, 300)
    assert session.main.core.lives > 1
    assert session.fork.at == session.main.at == 380
    session.seek(90)
    assert (session.fork.at, session.fork.core.ram()[LIVES], session.main.core.ram()[LIVES]) == (90, 1, 5)
    session.seek(0)  # the fork begins at 80
    assert session.fork.at == session.main.at == 80
    session.seek(380)
    kept = session.fork.core.ram()
    session.close_fork(keep=True)
    assert session.fork is None
    assert_array_equal(session.ram(), kept)
    session.seek(80)
    session.seek(380)
    assert_array_equal(session.ram(), kept)


def test_the_fork_left_alone_changes_nothing() -> None:
    session = new_session()
    play(session, 50)
    session.open_fork()
    play(session, 100)
    assert_array_equal(session.main.core.ram(), session.ram())
    session.close_fork()
    assert session.at == 150


def test_search_finds_the_lives() -> None:
    session = new_session()
    session.new_search()
    session.filter("equals", 5)
    while session.main.core.lives == 5:
        play(session, 10)
    session.filter("equals", 4)
    session.filter("unchanged")
    assert session.search.candidates == [LIVES]
    session.undo_filter()
    session.undo_filter()
    assert len(session.search.candidates) > 1
    with pytest.raises(ValueError, match="filter must be one of 'changed'"):
        session.filter("chnged")


def test_search_finds_what_follows_the_score() -> None:
    session = new_session()
    session.new_search()
    with pytest.raises(ValueError, match="the score has not changed since the search began"):
        session.filter("correlates")
    for points in (3, 1, 4):
        session.poke(SCORE, session.main.score + points)  # a written score is rewarded
        play(session, 5)
        session.filter("correlates")
    assert SCORE in session.search.candidates
    assert LIVES not in session.search.candidates
    session.undo_filter()
    session.poke(SCORE, 9)
    play(session, 1)
    session.filter("correlates")
    assert SCORE in session.search.candidates


def test_causes_in_a_state() -> None:
    session = new_session()
    play(session, 60)
    before = session.main.core.snapshot()
    paddle, source = session.pixels_of(PADDLE)
    rows = np.flatnonzero(paddle.any(axis=1))
    assert source == "state"
    assert paddle.sum() > 20
    assert rows.min() > 180
    y, x = np.argwhere(paddle)[0]
    assert PADDLE in session.bytes_of(int(x), int(y))[0]
    assert session.main.core.snapshot() == before


def test_causes_of_the_shipped_map() -> None:
    session = new_session()
    causes = session.readings.causes
    assert causes is not None
    pixels, source = session.pixels_of(100)  # nothing in the first frame
    assert source == "map"
    assert pixels.any()
    assert_array_equal(pixels, causes.bytes[100].pixels)
    y, x = np.argwhere(pixels)[0]
    found, elsewhere = session.bytes_of(int(x), int(y))
    assert 100 in elsewhere
    assert not set(found) & set(elsewhere)
    assert session.readings.facts()[PADDLE].startswith("By the causal map: ")


def test_the_end_of_a_game_pauses_a_person_and_begins_again_for_an_agent() -> None:
    session = new_session()
    session.poke(LIVES, 1)
    play(session, 20)
    session.let_agent_play(False)
    session.play()
    session.hold(0, 0, True)
    for _ in range(100):
        session.tick(0.25)
    assert session.over
    assert not session.playing
    assert "the game is over" in session.notice
    with pytest.raises(ValueError, match="the game is over"):
        session.play()
    session.let_agent_play(True)
    session.play()
    session.tick(0.1)
    assert session.main.core.lives == 5


@pytest.mark.parametrize(
    ("call", "error"),
    [
        (lambda s: s.poke(256, 0), ValueError),
        (lambda s: s.poke(0, 256), ValueError),
        (lambda s: s.poke("lives", 1), TypeError),
        (lambda s: s.freeze(-1), ValueError),
        (lambda s: s.seek(-1), ValueError),
        (lambda s: s.step(10**9), ValueError),
        (lambda s: s.hold(2, 0, False), ValueError),
        (lambda s: s.bytes_of(160, 0), ValueError),
        (lambda s: s.let_agent_play(True), ValueError),
        (lambda s: s.filter("between", 3, 2), ValueError),
        (lambda s: s.undo_filter(), ValueError),
    ],
)
def test_mistakes_change_nothing(call: object, error: type[Exception]) -> None:
    session = new_session()
    before = session.ram()
    with pytest.raises(error):
        call(session)  # type: ignore[operator]
    assert_array_equal(session.ram(), before)
    assert (session.at, session.changes, session.frozen) == (0, [], {})


class Broken(Sweeper):
    def act(self, core: object) -> int:
        return 99 if self.frames else super().act(core)


def test_an_agent_that_fails_pauses() -> None:
    session = new_session()
    session.agent = Broken()
    session.let_agent_play(True)
    session.play()
    session.tick(0.1)
    assert (session.at, session.playing) == (1, False)
    assert session.error.startswith("frame 1: the agent sweeper has failed")
    with pytest.raises(RuntimeError, match="has failed"):
        session.step()
    assert session.at == 1


def test_any_error_pauses_and_is_logged_in_one_line(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    session = new_session()
    play(session, 40)
    before = session.ram()
    with monkeypatch.context() as broken:
        broken.setattr(session.main.core, "act", lambda *arguments: {}["a\n\x1b[0m"])
        session.play()
        session.tick(0.1)
    assert (session.at, session.main.end, session.playing) == (40, 40, False)
    assert session.error.startswith("frame 40: KeyError(")
    (line,) = caplog.messages
    assert line.startswith("atari lab, frame 40: ")
    assert line.isprintable()
    assert_array_equal(session.ram(), before)
    session.play()
    session.tick(0.1)  # it plays on
    assert (session.at, session.playing) == (46, True)


def test_bytes_are_released_before_others_are_held() -> None:
    session = new_session()
    for bytes_ in (range(40), range(40, 80)):
        for index in list(session.frozen):
            session.release(index)
        for index in bytes_:
            session.freeze(index)
        session.step(5)
    session.seek(0)
    session.play()
    session.tick(0.1)
    session.tick(0.1)
    assert (session.at, session.playing, session.error) == (12, True, "")
    with pytest.raises(ValueError, match="at most 64 writes"):
        session.main.freeze(dict.fromkeys(range(65), 1))
    assert len(session.main.core.writes) == len(session.frozen) == 40  # nothing has changed


@pytest.mark.parametrize("seed", range(3))
def test_random_freezes_and_jumps_give_the_same_bytes(seed: int) -> None:
    source = np.random.default_rng(seed)
    session = new_session()
    session.agent = Sweeper()
    session.let_agent_play(True)
    session.agent.begin(session.main.core)
    seen = {0: session.ram()}
    for _ in range(20):
        for index in source.choice(128, source.integers(0, 50), replace=False).tolist():
            if index in session.frozen:
                session.release(index)
            elif len(session.frozen) < 64:
                session.freeze(index, int(source.integers(256)))
        if session.at == session.main.end:
            session.step(1)  # writes since the frame before are part of it
        else:
            seen = {frame: ram for frame, ram in seen.items() if frame <= session.at}
            session.take_over()
        for _ in range(source.integers(1, 40)):
            session.step(1)
            seen[session.at] = session.ram()
        for frame in source.integers(0, session.at + 1, 3).tolist():
            session.seek(frame)
            if frame in seen:
                assert_array_equal(session.ram(), seen[frame])
        session.seek(session.main.end)
        assert session.error == ""


def test_one_fork_at_a_time() -> None:
    session = new_session()
    session.open_fork()
    with pytest.raises(ValueError, match="a fork already"):
        session.open_fork()
    session.close_fork()
    session.close_fork()


def test_only_ataris() -> None:
    import gymnasium

    with pytest.raises(ValueError, match="use core='native'"):
        Session(AtariEnv("pong", core="ale"))
    with pytest.raises(TypeError, match=r"shows an atari\.AtariEnv, got CartPoleEnv"):
        Session(gymnasium.make("CartPole-v1"))
