"""Native cores share only compiled games, so the results of a core do not depend on other threads."""

import hashlib
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from atari.cores import NativeCore

# Every common kind of cartridge, a paddle game, and one whose cartridge has a random number generator.
GAMES = (
    "pong breakout enduro ms_pacman seaquest elevator_action montezuma_revenge robotank pitfall2 space_invaders".split()
)
CORES, THREADS, ACTS = 100, 8, 20


def digest(number: int) -> str:
    """A digest of all results of core `number` while it plays."""
    core = NativeCore(GAMES[number % len(GAMES)], seed=number, frame_skip=1 + number % 4, sound=True)
    actions = np.random.default_rng(number).integers(0, 18, ACTS)
    shown = hashlib.sha256()
    for action in actions.tolist():
        shown.update(str((core.act(action), core.lives, core.game_over)).encode())
        for array in (core.ram(), core.screen(), core.screen_rgb(), core.audio()):
            shown.update(array.tobytes())
    shown.update(core.snapshot())
    return shown.hexdigest()


def test_a_hundred_cores_on_eight_threads_show_what_they_show_one_after_the_other() -> None:
    with ThreadPoolExecutor(THREADS) as pool:
        together = list(pool.map(digest, range(CORES)))
    assert together == [digest(number) for number in range(CORES)]
    assert len(set(together)) == CORES


def test_a_core_may_be_handed_from_thread_to_thread() -> None:
    core, stays = NativeCore("pong", seed=3), NativeCore("pong", seed=3)
    with ThreadPoolExecutor(THREADS) as pool:
        moved = [pool.submit(core.act, i % 6).result() for i in range(200)]
    assert moved == [stays.act(i % 6) for i in range(200)]
    assert core.snapshot() == stays.snapshot()


def test_calls_of_several_threads_into_one_core_go_one_after_the_other() -> None:
    core, alone = NativeCore("pong", seed=3), NativeCore("pong", seed=3)

    def play(_: int) -> None:
        for _ in range(50):
            core.act(0)
            core.screen_rgb()

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(play, range(THREADS)))
    for _ in range(50 * THREADS):
        alone.act(0)
    assert core.frame_number == 50 * THREADS
    assert core.snapshot() == alone.snapshot()


def test_a_core_that_is_closed_while_other_threads_play_it_raises() -> None:
    core = NativeCore("pong")

    def play() -> None:
        while True:
            core.act(0)

    with ThreadPoolExecutor(THREADS) as pool:
        playing = [pool.submit(play) for _ in range(4)]
        core.act(0)
        core.close()
        for future in playing:
            with pytest.raises(RuntimeError, match="this core is closed; make a new one"):
                future.result()
