"""Threads and processes that share a vector environment: no hang, no crash, no observation written twice."""

import os
import sys
import threading
import time
from typing import Any

import gymnasium
import numpy as np
import pytest
from own_process import LIMIT, ended, run_program

import atari

STEPS, USERS = 150, 4


def make(num_envs: int = 2, **options: Any) -> atari.AtariVectorEnv:
    return atari.AtariVectorEnv("pong", num_envs, **options)


def run_all(work: Any, count: int) -> None:
    """Run `work(number)` in `count` threads; raise the first error of any."""
    errors: list[BaseException] = []

    def guarded(number: int) -> None:
        try:
            work(number)
        except BaseException as error:
            errors.append(error)

    threads = [threading.Thread(target=guarded, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]


def test_steps_of_threads_that_share_a_vector_run_one_at_a_time() -> None:
    envs = make(frameskip=4, noop_max=0, use_fire_reset=False)
    _, info = envs.reset(seed=0)
    start = info["frame_number"][0]

    def play(_: int) -> None:
        for _ in range(STEPS):
            envs.step(np.zeros(2, int))

    run_all(play, USERS)
    *_, info = envs.step(np.zeros(2, int))
    assert info["env_id"].tolist() == [0, 1]
    assert (info["frame_number"] - start == 4 * (USERS * STEPS + 1)).all()


@pytest.mark.parametrize("num_threads", [1, 3])
def test_observations_that_a_thread_holds_are_not_overwritten_by_other_threads(num_threads: int) -> None:
    envs = make(num_threads=num_threads)
    envs.reset(seed=0)
    overwritten = []

    def play(number: int) -> None:
        for step in range(STEPS):
            observation = envs.step(np.full(2, (step + number) % 6))[0]
            copy = observation.copy()
            time.sleep(0)
            overwritten.append((observation != copy).any())

    run_all(play, USERS)
    assert len(overwritten) == USERS * STEPS
    assert not any(overwritten)


def test_all_methods_may_be_called_while_other_threads_step() -> None:
    envs = make(render_mode="rgb_array")
    envs.reset(seed=0)
    state = envs.snapshot()
    calls = (
        lambda: envs.step(np.zeros(2, int)),
        lambda: envs.observe(),
        lambda: envs.reset(options={"reset_mask": np.array([True, False])}),
        lambda: envs.restore([0], envs.snapshot([1])),
        lambda: envs.restore(None, state),
        lambda: envs.fork(0, [1]),
        lambda: envs.render(),
        lambda: envs.mosaic(),
        lambda: envs.call("ram"),
        lambda: envs.lanes[1].set_ram(0, 1),
        lambda: envs.set_attr("difficulty", 0),
        lambda: envs.__getstate__(),
    )

    def use(number: int) -> None:
        for step in range(STEPS):
            calls[(step * (1 + number)) % len(calls)]()

    run_all(use, USERS)
    *_, info = envs.step(np.zeros(2, int))
    assert info["env_id"].tolist() == [0, 1]


def test_a_send_of_a_second_thread_is_refused_until_the_first_has_received() -> None:
    envs = make()
    envs.reset(seed=0)
    envs.send(np.zeros(2, int))

    def send(_: int) -> None:
        envs.send(np.zeros(2, int))

    with pytest.raises(gymnasium.error.AlreadyPendingCallError, match=r"call recv\(\) before the next send\(\)"):
        run_all(send, 1)
    envs.recv()


def test_a_signal_handler_that_closes_a_vector_in_recv_ends_it_with_that_error() -> None:
    """The handler runs where the results' buffer has been read and the engine has not been called."""
    envs = make()
    envs.reset(seed=0)

    def close_after_the_first_line(frame: Any, event: str, _: Any) -> Any:
        if frame.f_code.co_name != "_receive":
            return None
        if event == "line" and "results" in frame.f_locals:
            sys.settrace(None)
            envs.close()
        return close_after_the_first_line

    envs.send(np.zeros(2, int))
    before = sys.gettrace()
    sys.settrace(close_after_the_first_line)
    try:
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            envs.recv()
    finally:
        sys.settrace(before)


PROGRAMS = {
    "a vector that another thread closes ends the steps with an error": """
        import threading, gymnasium, numpy as np, atari
        for round in range(60):
            envs = atari.AtariVectorEnv("pong", 2, num_threads=1 + round % 3)
            envs.reset(seed=0)
            timer = threading.Timer(0.001 * (round % 8), envs.close)
            timer.start()
            try:
                while True:
                    envs.step(np.zeros(2, int))
            except gymnasium.error.ClosedEnvironmentError:
                pass
            timer.join()
    """,
    "a signal handler may close a vector during a step": """
        import signal, gymnasium, numpy as np, atari
        for round in range(60):
            envs = atari.AtariVectorEnv("pong", 2, obs_type="ram", frameskip=1)
            envs.reset(seed=0)
            signal.signal(signal.SIGALRM, lambda number, frame: envs.close())
            signal.setitimer(signal.ITIMER_REAL, 0.001)
            try:
                while True:
                    envs.step(np.zeros(2, int))
            except gymnasium.error.ClosedEnvironmentError:
                pass
    """,
    # The threads drop the last references to the snapshots, and to their games, while `close` joins them.
    "a vector with the snapshots of a closed one can be closed": """
        import numpy as np, atari
        for _ in range(60):
            first, second = (atari.AtariVectorEnv("pong", 4, num_threads=4, obs_type="ram") for _ in range(2))
            first.reset(seed=0)
            second.reset(seed=0)
            states = first.snapshot()
            first.close()
            second.restore(None, states)
            del states
            second.send(np.zeros(4, int))
            second.close()
    """,
    # Another thread writes into the array meanwhile: NumPy copies so many numbers without the interpreter's lock.
    "actions are checked as they are played": """
        import threading, numpy as np, atari
        count, length = 1024, 1 << 16
        envs = atari.AtariVectorEnv("pong", count, obs_type="ram", autoreset_mode="Disabled", max_num_frames_per_episode=1)
        envs.reset(seed=0)
        envs.step(np.zeros(count, int))  # All episodes end, so a step takes no time.
        written, bad, good = np.zeros(length, np.int64), np.full(length, 1 << 44), np.zeros(length, np.int64)
        done = False
        def write():
            while not done:
                written[:] = bad
                written[:] = good
        writer = threading.Thread(target=write)
        writer.start()
        for step in range(12_000):
            first = step * 977 % (length - count)
            try:
                envs.step(written[first : first + count])
            except ValueError as error:
                assert "is not within 0..5" in str(error)
        done = True
        writer.join()
    """,
    "snapshots of a list that another thread empties are restored": """
        import pickle, threading, numpy as np, atari
        envs = atari.AtariVectorEnv("pong", 32, obs_type="ram", frameskip=1)
        envs.reset(seed=0)
        saved, states, done = pickle.dumps([one.state for one in envs.snapshot()]), [], False
        def empty():
            while not done:
                states.clear()
        other = threading.Thread(target=empty)
        other.start()
        for _ in range(150):
            states.extend(pickle.loads(saved))
            try:
                envs._engine.restore(range(32), states)
            except ValueError as error:
                assert "a snapshot for each environment" in str(error)
        done = True
        other.join()
    """,
    "environment numbers that another thread writes are not read": """
        import threading, numpy as np, atari
        envs = atari.AtariVectorEnv("pong", 1024, obs_type="ram", autoreset_mode="Disabled", max_num_frames_per_episode=1)
        envs.reset(seed=0)
        envs.step(np.zeros(1024, int))  # All episodes end, so a step takes no time.
        arrays = [array for results in envs._buffers for array in results.batch.arrays.values()]
        numbers, done = [array for array in arrays if array.dtype == np.int32], False
        def write():
            while not done:
                for array in numbers:
                    array[:] = 1 << 30
        writer = threading.Thread(target=write)
        writer.start()
        for _ in range(3000):
            envs.step(np.zeros(1024, int))
        done = True
        writer.join()
    """,
}
if hasattr(os, "fork"):
    PROGRAMS["a process that is forked during a step is told"] = """
        import os, threading, numpy as np, atari
        envs = atari.AtariVectorEnv("pong", 4, num_threads=2)
        envs.reset(seed=0)
        done = False
        def play():
            while not done:
                envs.step(np.zeros(4, int))
        player = threading.Thread(target=play)
        player.start()
        for round in range(25):
            child = os.fork()
            if child == 0:
                for use in (lambda: envs.step(np.zeros(4, int)), envs.snapshot, lambda: envs.lanes[0].lives):
                    try:
                        use()
                    except RuntimeError as error:
                        assert "process was forked" in str(error)
                    else:
                        os._exit(1)
                envs.close()
                os._exit(0)
            assert os.waitpid(child, 0)[1] == 0
        done = True
        player.join()
    """


@pytest.fixture(scope="module")
def played() -> Any:
    """All programs, one after the other in one process, whose start takes longer than most of them."""
    begin = "import sys, textwrap\n"
    each = "print({0!r}, file=sys.stderr, flush=True)\nexec(textwrap.dedent({1!r}), {{}})\nprint({0!r}, flush=True)\n"
    script = begin + "".join(each.format(name, program) for name, program in PROGRAMS.items())
    return ended(script, "-X", "faulthandler", "-W", "ignore::DeprecationWarning", limit=len(PROGRAMS) * LIMIT)


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_ends(name: str, played: Any) -> None:
    """The last name in stderr is that of the program that has crashed or raised an error."""
    assert name in played.stdout.splitlines(), played.stderr
    assert (played.returncode, "Exception in thread" in played.stderr) == (0, False), played.stderr


@pytest.mark.parametrize("num_threads", [1, 2])
def test_daemon_threads_may_step_while_the_interpreter_ends(num_threads: int) -> None:
    program = f"""
        import threading, time, numpy as np, atari
        envs = atari.AtariVectorEnv("pong", 4, num_threads={num_threads})
        envs.reset(seed=0)
        def play():
            while True:
                envs.step(np.zeros(4, int))
        for _ in range(3):
            threading.Thread(target=play, daemon=True).start()
        time.sleep(0.05)
        print("ends")
    """
    for _ in range(2):
        assert run_program(program) == "ends\n"
