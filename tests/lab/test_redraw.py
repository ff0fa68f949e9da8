"""`core.redraw()` draws the present RAM and changes nothing."""

from typing import Any

import numpy as np
import pytest

import atari
from atari.cores import AleCore, NativeCore, PlainCore

BALL_X = 49


@pytest.mark.parametrize("game", [game.id for game in atari.games.playable()])
def test_the_state_stays_to_the_byte(game: str) -> None:
    core, twin = NativeCore(game, seed=1), NativeCore(game, seed=1)
    for one in (core, twin):
        one.reset()
    for frame in range(60):
        for one in (core, twin):
            one.act(frame // 3 % 18)
        if frame % 13 == 0:
            before = core.snapshot()
            assert core.redraw().shape == (*core.game.screen.shape, 3)
            assert core.snapshot() == before
    for frame in range(20):
        assert core.act(frame % 18) == twin.act(frame % 18)
        assert (core.screen() == twin.screen()).all()
        assert (core.ram() == twin.ram()).all()


def in_play(core: Any) -> Any:
    core.reset()
    while not 60 < core.ram()[BALL_X] < 180:
        core.act(0)
    return core


@pytest.mark.parametrize("kind", [NativeCore, PlainCore])
def test_a_byte_that_was_written_is_seen(kind: Any) -> None:
    core = in_play(kind("pong", seed=0))
    shown = core.screen_rgb()
    still = core.redraw()
    core.set_ram(BALL_X, 150)
    assert (core.screen_rgb() == shown).all()  # the write alone shows nothing
    redrawn = core.redraw()
    rows, columns, _ = np.nonzero(redrawn != still)
    assert 0 < len(rows) < 60
    assert abs(columns - 101).min() < 8  # where the label says that the ball is: 150 - 49
    out = np.empty_like(redrawn)
    assert core.redraw(out) is out
    assert (out == redrawn).all()


def test_sound_and_recording_do_not_notice() -> None:
    core, twin = NativeCore("seaquest", sound=True), NativeCore("seaquest", sound=True)
    for frame in range(200):
        if frame % 7 == 0:
            core.redraw()
        assert core.act(frame % 18) == twin.act(frame % 18)
        assert (core.audio() == twin.audio()).all()


def test_a_lane_of_a_vector() -> None:
    envs, twins = (atari.AtariVectorEnv("breakout", 2) for _ in range(2))
    for one in (envs, twins):
        one.reset(seed=0)
    for step in range(30):
        actions = np.full(2, step % 4)
        a, b = envs.step(actions), twins.step(actions)
        assert (a[0] == b[0]).all()
        assert (a[1] == b[1]).all()
        lane = envs.lanes[step % 2]
        states = [one.save(lane.index) for one in (envs._engine, twins._engine)]  # type: ignore[union-attr]
        before = lane.redraw()
        assert envs._engine.save(lane.index) == states[0] == states[1]  # type: ignore[union-attr]
    lane.set_ram(72, 100 if lane.ram()[72] > 120 else 150)  # the paddle
    assert (lane.redraw() != before).any()
    out = np.empty_like(before)
    assert lane.redraw(out) is out


def test_bad_arguments() -> None:
    core = NativeCore("pong")
    with pytest.raises(ValueError, match="out must be a writable"):
        core.redraw(np.empty(3, np.uint8))
    with pytest.raises(NotImplementedError, match="cannot take a frame back"):
        AleCore("pong").redraw()
    core.close()
    with pytest.raises(RuntimeError, match="closed"):
        core.redraw()
