"""The inspector's inspection, without a page: playing, going back, changing RAM, forks, search."""

import numpy as np
import pytest
from inspector_tools import LIVES, PADDLE, SCORE, Sweeper, new_inspection, play, ram_at
from numpy.testing import assert_array_equal

import atari._emulator as _emulator
from atari.env import AtariEnv
from atari.games.actions import Action
from atari.lab.inspector import timeline
from atari.lab.inspector.inspection import Inspection

SCORE_PONG, ENEMY_Y = 14, 50
HELD_Y = 120  # by lazy_enemy


@pytest.fixture
def inspection() -> Inspection:
    return new_inspection()


def test_time_plays_frames_at_the_speed_of_the_console(inspection: Inspection) -> None:
    inspection.tick(1.0)
    assert inspection.at == 0  # paused
    inspection.play()
    inspection.tick(0.1)
    assert inspection.at == 6
    inspection.set_speed(4.0)
    inspection.tick(0.1)
    assert inspection.at == 30
    inspection.tick(100)  # the page slept; the lost time is dropped
    assert inspection.at == 90


def test_going_back_gives_the_same_bytes(inspection: Inspection) -> None:
    seen = []
    for _ in range(200):
        play(inspection, 1)
        seen.append((inspection.ram(), inspection.main.core.screen(), inspection.main.score))
    for frame in (200, 1, 31, 30, 29, 150, 151, 91):
        inspection.seek(frame)
        assert inspection.at == frame
        assert inspection.main.end == 200
        ram, screen, score = seen[frame - 1]
        assert_array_equal(inspection.ram(), ram)
        assert_array_equal(inspection.main.core.screen(), screen)
        assert inspection.main.score == score
        assert_array_equal(ram_at(inspection, frame), ram)
    inspection.seek(10**6)
    assert inspection.at == 200
    inspection.seek(100)
    inspection.step(5)  # follows what was recorded
    assert_array_equal(inspection.ram(), seen[104][0])


def test_a_key_takes_over_what_was_recorded(inspection: Inspection) -> None:
    play(inspection, 100)
    inspection.seek(50)
    inspection.hold(0, 0, False)
    assert inspection.main.end == 100
    inspection.hold(0, 1, False)
    assert (inspection.main.end, inspection.by_agent, inspection.action) == (50, False, Action.RIGHT)
    before = inspection.ram()[PADDLE]
    inspection.step(10)
    assert (inspection.main.end, inspection.at) == (60, 60)
    inspection.hold(0, 1, False)
    inspection.playing = True
    inspection.tick(0.2)
    assert inspection.ram()[PADDLE] > before


def test_a_press_while_paused_says_so(inspection: Inspection) -> None:
    inspection.hold(0, 0, False)
    assert inspection.notice == ""
    inspection.hold(0, 0, True)
    assert inspection.notice == "the game is paused; Play (P) goes on"
    play(inspection, 100)
    inspection.seek(40)
    inspection.hold(0, 0, True)
    assert inspection.notice.endswith("; the 60 frames recorded after this one were dropped")
    inspection.notice = ""
    inspection.play()
    inspection.hold(0, 1, False)
    assert inspection.notice == ""


def test_the_oldest_frames_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timeline, "MOST_FRAMES", 900)
    inspection = new_inspection("pong")
    rams = []
    for _ in range(1300):
        play(inspection, 1)
        rams.append(inspection.ram())
    assert (inspection.main.first, inspection.main.end) == (600, 1300)
    for frame in (600, 601, 777, 1299):
        inspection.seek(frame)
        assert_array_equal(inspection.ram(), rams[frame - 1])
    inspection.seek(0)
    assert inspection.at == 600


def test_a_poke_is_seen_before_a_frame_is_played_and_can_be_undone(inspection: Inspection) -> None:
    play(inspection, 60)
    before, screen = inspection.ram(), inspection.screen(inspection.main)[0]
    inspection.poke(PADDLE, 60)
    shown, preview = inspection.screen(inspection.main)
    assert preview
    assert (shown != screen).any()
    assert inspection.ram()[PADDLE] == 60
    assert inspection.at == 60
    inspection.undo()
    assert_array_equal(inspection.ram(), before)
    assert not inspection.screen(inspection.main)[1]
    inspection.poke(0x80 + LIVES, 3)  # an address
    inspection.step()
    assert inspection.ram()[LIVES] == 3
    inspection.undo()
    assert inspection.ram()[LIVES] == before[LIVES]
    assert "was written back" in inspection.notice


def test_a_poke_in_the_past_drops_the_future_and_is_part_of_it(inspection: Inspection) -> None:
    play(inspection, 90)
    inspection.seek(40)
    inspection.poke(LIVES, 2)
    play(inspection, 20)
    after = inspection.ram()
    inspection.seek(10)
    inspection.seek(60)
    assert_array_equal(inspection.ram(), after)
    assert after[LIVES] == 2


def test_frozen_bytes_hold_at_every_frame(inspection: Inspection) -> None:
    inspection.freeze(LIVES, 5)
    inspection.freeze(PADDLE)
    held = inspection.ram()[PADDLE]
    play(inspection, 400)
    rams = np.stack([ram_at(inspection, frame) for frame in range(1, 401)])
    assert (rams[:, LIVES] == 5).all()
    assert (rams[:, PADDLE] == held).all()
    inspection.release(LIVES)
    inspection.release(PADDLE)
    play(inspection, 300)
    assert inspection.ram()[LIVES] < 5
    inspection.undo()
    assert inspection.frozen == {PADDLE: held}


def test_frozen_lives_are_never_seen_lost_by_the_rules(inspection: Inspection) -> None:
    inspection.freeze(LIVES, 1)
    play(inspection, 900)
    assert inspection.main.core.lives == 1
    assert not inspection.over
    seen = inspection.ram()
    inspection.seek(400)
    inspection.seek(900)
    assert_array_equal(inspection.ram(), seen)
    loser = new_inspection()
    loser.poke(LIVES, 1)
    play(loser, 300)
    assert loser.main.core.lives == 0


def test_a_freeze_of_the_game_and_one_of_its_fork_are_apart(inspection: Inspection) -> None:
    inspection.freeze(LIVES, 3)
    play(inspection, 20)
    inspection.open_fork()
    inspection.freeze(PADDLE, 60)
    inspection.release(LIVES)
    inspection.poke(LIVES, 2)
    play(inspection, 20)
    assert inspection.fork is not None
    assert (inspection.main.core.ram()[LIVES], inspection.fork.core.ram()[LIVES]) == (3, 2)
    assert inspection.fork.core.ram()[PADDLE] == 60 != inspection.main.core.ram()[PADDLE]
    inspection.close_fork()
    assert inspection.frozen == {LIVES: 3}
    assert len(inspection.changes) == 1
    inspection.undo()
    assert inspection.frozen == {}
    inspection.open_fork()
    inspection.freeze(PADDLE, 60)
    inspection.close_fork(keep=True)
    play(inspection, 5)
    assert inspection.frozen == {PADDLE: 60}
    assert inspection.ram()[PADDLE] == 60


def test_a_release_ends_it_on_the_core_at_once(inspection: Inspection) -> None:
    inspection.freeze(PADDLE, 60)
    inspection.step(3)
    inspection.release(PADDLE)
    env = inspection.env
    for _ in range(5):
        env.step(int(Action.RIGHT))
    assert env.core.ram()[PADDLE] != 60


def test_an_intervention_is_switched_on_and_off_as_time_goes() -> None:
    inspection = new_inspection("pong")
    inspection.step(100)
    inspection.freeze(SCORE_PONG, 7)
    inspection.intervene("lazy_enemy")
    inspection.intervene("lazy_enemy")  # it is on already
    inspection.step(60)
    inspection.intervene("slow_enemy")  # has conditions and remembers values
    inspection.step(60)
    inspection.intervene("lazy_enemy", on=False)
    inspection.step(60)
    seen = [ram_at(inspection, frame)[ENEMY_Y] for frame in range(281)]
    assert {*seen[101:221]} == {HELD_Y}
    assert len({*seen[:101]}) > 1 < len({*seen[221:]})
    assert ram_at(inspection, 280)[SCORE_PONG] == 7
    assert [*inspection.active.added] == ["slow_enemy"]
    for frame in (150, 130, 279, 101, 250, 20, 280):
        inspection.seek(frame)
        assert_array_equal(inspection.ram(), ram_at(inspection, frame))
    inspection.undo()
    assert [*inspection.active.added] == ["slow_enemy", "lazy_enemy"]
    inspection.step(1)
    assert inspection.ram()[ENEMY_Y] == HELD_Y
    assert [change.kind for change in inspection.changes] == ["freeze", "intervention", "intervention"]


def test_interventions_of_a_fork_and_of_a_task() -> None:
    inspection = Inspection(AtariEnv("pong", interventions=["lazy_enemy"], frameskip=1), seed=0)
    assert "lazy_enemy" not in inspection.interventions
    for name in ("lazy_enemy", "nothing"):
        with pytest.raises(ValueError, match="intervention must be one of 'falling_ball'"):
            inspection.intervene(name)
    inspection.intervene("falling_ball")
    inspection.open_fork()
    inspection.intervene("shaky_ball")
    inspection.step(250)
    assert (inspection.ram() != inspection.main.core.ram()).any()
    inspection.close_fork()
    assert [*inspection.active.added] == ["falling_ball"]
    inspection.open_fork()
    inspection.intervene("falling_ball", on=False)
    inspection.step(20)
    ram = inspection.ram()
    inspection.close_fork(keep=True)
    assert inspection.active.added == {}
    assert_array_equal(inspection.ram(), ram)
    assert inspection.ram()[ENEMY_Y] == HELD_Y
    for index in range(62):
        inspection.freeze(index)
    with pytest.raises(ValueError, match="at most 64 writes"):
        inspection.intervene("perfect_enemy")
    assert (len(inspection.frozen), inspection.active.added) == (62, {})
    inspection.step(1)
    assert inspection.ram()[ENEMY_Y] == inspection.frozen[ENEMY_Y]


def test_at_most_64_bytes_are_held(inspection: Inspection) -> None:
    for index in range(64):
        inspection.freeze(index)
    with pytest.raises(ValueError, match="at most 64 writes"):
        inspection.freeze(64)
    assert len(inspection.frozen) == len(inspection.changes) == 64


def test_a_preview_is_what_redraw_draws() -> None:
    """`Inspection` shows it as palette indices, which the page draws; `redraw` gives colours."""
    for game in ("breakout", "pong", "seaquest"):
        inspection = new_inspection(game)
        inspection.step(120)
        inspection.poke(PADDLE, 60)
        shown, preview = inspection.screen(inspection.main)
        assert preview
        colours = _emulator.palette(inspection.game.screen.format)[shown]
        assert_array_equal(colours, inspection.main.core.redraw())


def test_a_fork_plays_beside_the_game(inspection: Inspection) -> None:
    play(inspection, 80)
    inspection.open_fork()
    assert inspection.fork is not None
    inspection.poke(LIVES, 1)
    assert inspection.main.core.ram()[LIVES] == 5
    assert inspection.ram()[LIVES] == 1
    play(inspection, 300)
    assert inspection.main.core.lives > 1
    assert inspection.fork.at == inspection.main.at == 380
    inspection.seek(90)
    assert (inspection.fork.at, inspection.fork.core.ram()[LIVES], inspection.main.core.ram()[LIVES]) == (90, 1, 5)
    inspection.seek(0)  # the fork begins at 80
    assert inspection.fork.at == inspection.main.at == 80
    inspection.seek(380)
    kept = inspection.fork.core.ram()
    inspection.close_fork(keep=True)
    assert inspection.fork is None
    assert_array_equal(inspection.ram(), kept)
    inspection.seek(80)
    inspection.seek(380)
    assert_array_equal(inspection.ram(), kept)


def test_the_fork_left_alone_changes_nothing(inspection: Inspection) -> None:
    play(inspection, 50)
    inspection.open_fork()
    play(inspection, 100)
    assert_array_equal(inspection.main.core.ram(), inspection.ram())
    inspection.close_fork()
    assert inspection.at == 150


def test_search_finds_the_lives(inspection: Inspection) -> None:
    inspection.new_search()
    inspection.filter("equals", 5)
    while inspection.main.core.lives == 5:
        play(inspection, 10)
    inspection.filter("equals", 4)
    inspection.filter("unchanged")
    assert inspection.search.candidates == [LIVES]
    inspection.undo_filter()
    inspection.undo_filter()
    assert len(inspection.search.candidates) > 1


def test_search_finds_what_follows_the_score(inspection: Inspection) -> None:
    inspection.new_search()
    for points in (3, 1, 4):
        inspection.poke(SCORE, inspection.main.score + points)  # a written score is rewarded
        play(inspection, 5)
        inspection.filter("correlates")
    assert SCORE in inspection.search.candidates
    assert LIVES not in inspection.search.candidates
    inspection.undo_filter()
    inspection.poke(SCORE, 9)
    play(inspection, 1)
    inspection.filter("correlates")
    assert SCORE in inspection.search.candidates


def test_causes_in_a_state(inspection: Inspection) -> None:
    play(inspection, 60)
    before = inspection.main.core.snapshot()
    paddle, source = inspection.pixels_of(PADDLE)
    rows = np.flatnonzero(paddle.any(axis=1))
    assert source == "state"
    assert paddle.sum() > 20
    assert rows.min() > 180
    y, x = np.argwhere(paddle)[0]
    assert PADDLE in inspection.bytes_of(int(x), int(y))[0]
    assert inspection.main.core.snapshot() == before


def test_causes_of_the_shipped_map(inspection: Inspection) -> None:
    causes = inspection.readings.causes
    assert causes is not None
    pixels, source = inspection.pixels_of(100)  # nothing in the first frame
    assert source == "map"
    assert pixels.any()
    assert_array_equal(pixels, causes.bytes[100].pixels)
    y, x = np.argwhere(pixels)[0]
    found, elsewhere = inspection.bytes_of(int(x), int(y))
    assert 100 in elsewhere
    assert not set(found) & set(elsewhere)
    assert inspection.readings.facts()[PADDLE].startswith("By the causal map: ")


def test_the_end_of_a_game_pauses_a_person_and_begins_again_for_an_agent(inspection: Inspection) -> None:
    inspection.poke(LIVES, 1)
    play(inspection, 20)
    inspection.let_agent_play(False)
    inspection.play()
    inspection.hold(0, 0, True)
    for _ in range(100):
        inspection.tick(0.25)
    assert inspection.over
    assert not inspection.playing
    assert "the game is over" in inspection.notice
    with pytest.raises(ValueError, match="the game is over"):
        inspection.play()
    inspection.let_agent_play(True)
    inspection.play()
    inspection.tick(0.1)
    assert inspection.main.core.lives == 5


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
        (lambda s: s.undo(), ValueError),
        (lambda s: s.set_speed(3.0), ValueError),
        (lambda s: s.filter("chnged"), ValueError),
        (lambda s: s.filter("correlates"), ValueError),  # the score has not changed since the search began
        (lambda s: s.open_fork() or s.open_fork(), ValueError),
    ],
)
def test_mistakes_change_nothing(call: object, error: type[Exception]) -> None:
    inspection = new_inspection()
    before = inspection.ram()
    with pytest.raises(error):
        call(inspection)  # type: ignore[operator]
    inspection.close_fork()
    inspection.close_fork()
    assert_array_equal(inspection.ram(), before)
    assert (inspection.at, inspection.changes, inspection.frozen) == (0, [], {})


class Broken(Sweeper):
    def act(self, core: object) -> int:
        return 99 if self.frames else super().act(core)


def test_an_agent_that_fails_pauses(inspection: Inspection) -> None:
    inspection.agent = Broken()
    inspection.let_agent_play(True)
    inspection.play()
    inspection.tick(0.1)
    assert (inspection.at, inspection.playing) == (1, False)
    assert inspection.error.startswith("frame 1: the agent sweeper has failed")
    with pytest.raises(RuntimeError, match="has failed"):
        inspection.step()
    assert inspection.at == 1


def test_any_error_pauses_and_is_logged_in_one_line(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    inspection = new_inspection()
    play(inspection, 40)
    before = inspection.ram()
    with monkeypatch.context() as broken:
        broken.setattr(inspection.main.core, "act", lambda *arguments: {}["a\n\x1b[0m"])
        inspection.play()
        inspection.tick(0.1)
    assert (inspection.at, inspection.main.end, inspection.playing) == (40, 40, False)
    assert inspection.error.startswith("frame 40: KeyError(")
    (line,) = caplog.messages
    assert line.startswith("atari lab, frame 40: ")
    assert line.isprintable()
    assert_array_equal(inspection.ram(), before)
    inspection.play()
    inspection.tick(0.1)  # it plays on
    assert (inspection.at, inspection.playing) == (46, True)


def test_bytes_are_released_before_others_are_held(inspection: Inspection) -> None:
    for bytes_ in (range(40), range(40, 80)):
        for index in list(inspection.frozen):
            inspection.release(index)
        for index in bytes_:
            inspection.freeze(index)
        inspection.step(5)
    inspection.seek(0)
    inspection.play()
    inspection.tick(0.1)
    inspection.tick(0.1)
    assert (inspection.at, inspection.playing, inspection.error) == (12, True, "")
    with pytest.raises(ValueError, match="at most 64 writes"):
        inspection.main.freeze(dict.fromkeys(range(65), 1))
    assert len(inspection.main.core.writes) == len(inspection.frozen) == 40  # nothing has changed


@pytest.mark.parametrize("seed", range(3))
def test_random_freezes_and_jumps_give_the_same_bytes(seed: int) -> None:
    source = np.random.default_rng(seed)
    inspection = new_inspection()
    inspection.agent = Sweeper()
    inspection.let_agent_play(True)
    inspection.agent.begin(inspection.main.core)
    seen = {0: inspection.ram()}
    for _ in range(20):
        for index in source.choice(128, source.integers(0, 50), replace=False).tolist():
            if index in inspection.frozen:
                inspection.release(index)
            elif len(inspection.frozen) < 64:
                inspection.freeze(index, int(source.integers(256)))
        if inspection.at == inspection.main.end:
            inspection.step(1)  # writes since the frame before are part of it
        else:
            seen = {frame: ram for frame, ram in seen.items() if frame <= inspection.at}
            inspection.take_over()
        for _ in range(source.integers(1, 40)):
            inspection.step(1)
            seen[inspection.at] = inspection.ram()
        for frame in source.integers(0, inspection.at + 1, 3).tolist():
            inspection.seek(frame)
            if frame in seen:
                assert_array_equal(inspection.ram(), seen[frame])
        inspection.seek(inspection.main.end)
        assert inspection.error == ""


def test_only_ataris() -> None:
    import gymnasium

    with pytest.raises(ValueError, match="use core='native'"):
        Inspection(AtariEnv("pong", core="ale"))
    with pytest.raises(TypeError, match=r"shows an atari\.AtariEnv, got CartPoleEnv"):
        Inspection(gymnasium.make("CartPole-v1"))
