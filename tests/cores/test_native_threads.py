"""Native cores share only compiled games, so the results of a core do not depend on other threads."""

import hashlib
import os
import threading
import time
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from own_process import run_program

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


def test_an_environment_that_another_thread_closes_ends_the_steps_with_an_error() -> None:
    """The environment holds the last reference to its game."""
    run_program("""
        import threading, atari
        from atari.cores import native
        for round in range(72):
            env = atari.AtariEnv("pong")
            native.compiled.cache_clear()
            env.reset()
            timer = threading.Timer(0.0005 * (round % 8), env.close)
            timer.start()
            try:
                while True:
                    env.step(0)
            except RuntimeError as error:
                assert "this core is closed" in str(error)
            timer.join()
    """)


def test_other_threads_run_while_a_thread_waits_for_the_core() -> None:
    core = NativeCore("pitfall", frame_skip=10_000)
    rounds, turns = 0, []
    playing = True

    def count() -> None:
        nonlocal rounds
        while playing:
            rounds += 1

    def read() -> None:
        while playing:
            before = rounds
            assert core.lives == 3
            turns.append(rounds - before)

    others = [threading.Thread(target=use) for use in (count, read)]
    for other in others:
        other.start()
    core.act(0)
    playing = False
    for other in others:
        other.join()
    assert max(turns) > 100


def test_an_array_that_a_thread_writes_to_is_not_resized() -> None:
    core = NativeCore("pitfall", frame_skip=10_000)
    out = np.zeros(128, np.uint8)
    for _ in range(100):  # until the reader waits for the player, which may end first on a busy machine
        player = threading.Thread(target=core.act, args=(0,))
        reader = threading.Thread(target=core.ram, kwargs={"out": out})
        player.start()
        time.sleep(0.05)
        reader.start()
        while reader.is_alive() and not weakref.getweakrefcount(out):
            time.sleep(0.001)
        if waits := reader.is_alive():
            with pytest.raises(ValueError, match="cannot resize"):
                out.resize((1,), refcheck=False)
        player.join()
        reader.join()
        if waits:
            break
    assert waits
    out.resize((1,), refcheck=False)


def test_daemon_threads_may_play_while_the_interpreter_ends() -> None:
    program = """
        import threading, time, atari
        env = atari.AtariEnv("pong")
        env.reset()
        core = atari.cores.NativeCore("pong", color_averaging=True)
        def step():
            while True:
                env.core.act(0)
        def render():
            while True:
                core.act(0)
                core.screen_rgb()
        for play in (step, step, render, render):
            threading.Thread(target=play, daemon=True).start()
        time.sleep(0.05)
        print("ends")
    """
    for _ in range(2):
        assert run_program(program) == "ends\n"


if hasattr(os, "fork"):

    def test_a_process_that_is_forked_while_a_thread_plays_is_told() -> None:
        """A core that no thread was playing goes on in the child."""
        run_program("""
            import os, threading, atari
            played, idle = (atari.cores.NativeCore("pong", frame_skip=300) for _ in range(2))
            done = False
            def play():
                while not done:
                    played.act(0)
            player = threading.Thread(target=play)
            player.start()
            for _ in range(25):
                child = os.fork()
                if child == 0:
                    refused = 0
                    for use in (lambda: played.act(0), lambda: played.lives, played.save):
                        try:
                            use()
                        except RuntimeError as error:
                            assert "when this process was forked" in str(error)
                            refused += 1
                    assert refused in (0, 3)
                    idle.act(0)
                    atari.cores.NativeCore("pong").act(0)
                    os._exit(refused)
                status = os.waitpid(child, 0)[1]
                assert os.waitstatus_to_exitcode(status) in (0, 3)
            done = True
            player.join()
        """)
