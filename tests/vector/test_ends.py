"""How vector environments end: closed, collected, interrupted, failed, forked. No thread and no memory is left."""

import gc
import multiprocessing
import os
import pickle
import resource
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from env_tools import needs_gymnasium_1
from gymnasium.utils.env_checker import data_equivalence
from vector_tools import begun, make

import atari
from atari.cores.options import CoreOptions


def play(envs: atari.AtariVectorEnv) -> None:
    envs.reset()
    for _ in range(3):
        envs.step(np.zeros(envs.batch_size, int))


def threads() -> set[Any]:
    """The threads of this process, including those started in C++. Threads of earlier tests may end at any time."""
    return set(os.listdir("/proc/self/task") if os.path.isdir("/proc/self/task") else threading.enumerate())


def test_close() -> None:
    before = threads()
    envs = make(num_envs=4, num_threads=4)
    assert len(threads() - before) == 3
    envs.reset()
    envs.close()
    assert not threads() - before
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        envs.step(np.zeros(4, int))
    envs.close()
    envs.reset()
    assert len(threads() - before) == 3
    envs.close()
    assert not threads() - before


def test_one_thread_is_the_caller() -> None:
    before = threads()
    envs = begun(num_envs=4, num_threads=1)
    envs.step(np.zeros(4, int))
    assert not threads() - before
    envs.close()


def test_close_while_environments_are_stepped() -> None:
    before = threads()
    envs = begun(num_envs=8, num_threads=3)
    envs.send(np.zeros(8, int))
    envs.close()
    assert not threads() - before
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        envs.recv()


@needs_gymnasium_1
def test_garbage_collection() -> None:
    gc.collect()
    before = threads()
    envs = begun(num_envs=4, num_threads=4)
    envs.send(np.zeros(4, int))
    gone = weakref.ref(envs)
    del envs
    gc.collect()
    assert gone() is None
    assert not threads() - before


CALLS = {
    "partial reset": lambda envs: envs.reset(options={"reset_mask": np.array([True, False])}),
    "step": lambda envs: envs.step(np.zeros(2, int)),
    "send": lambda envs: envs.send(np.zeros(2, int)),
    "recv": lambda envs: envs.recv(),
    "observe": lambda envs: envs.observe(),
    "render": lambda envs: envs.render(),
    "mosaic": lambda envs: envs.mosaic(),
    "snapshot": lambda envs: envs.snapshot(),
    "restore": lambda envs: envs.restore(None, []),
    "fork": lambda envs: envs.fork(0, [1]),
    "lanes": lambda envs: envs.lanes,
    "call": lambda envs: envs.call("ram"),
    "get_attr": lambda envs: envs.get_attr("lives"),
    "set_attr": lambda envs: envs.set_attr("mode", 0),
    "pickle": pickle.dumps,
}


@pytest.mark.parametrize("name", CALLS)
def test_closed_environments_raise(name: str) -> None:
    envs = begun(num_envs=2, render_mode="rgb_array")
    envs.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError, match=r"closed; call reset\(\)"):
        CALLS[name](envs)


@pytest.mark.parametrize("sent", [False, True])
@pytest.mark.parametrize("batch_size", [0, 3])
def test_a_reset_after_close_goes_on_as_without_it(sent: bool, batch_size: int) -> None:
    """As in ale-py: generators and counters continue, and what was set by `set_attr` stays."""
    options = {"repeat_action_probability": 0.25, "batch_size": batch_size}
    closed, twin = make("breakout", 3, **options), make("breakout", 3, **options)
    for envs in (closed, twin):
        envs.reset(seed=3)
        for _ in range(20):
            envs.step(np.ones(3, int))
        envs.lanes[0].mode = 4
        envs.set_attr("difficulty", [0, 1, 0])
        if sent:
            envs.send(np.ones(3, int))
    closed.close()
    closed.close()
    if sent:
        twin.recv()
    first, second = closed.reset(), twin.reset()
    assert data_equivalence(first, second)
    assert first[1]["frame_number"].all()
    for _ in range(30):
        assert data_equivalence(closed.step(np.full(3, 2)), twin.step(np.full(3, 2)))
    assert closed.get_attr("mode") == (4, 0, 0)
    assert closed.get_attr("difficulty") == (0, 1, 0)


def test_lanes_that_are_held_do_not_keep_threads() -> None:
    gc.collect()
    before = threads()
    envs = make(num_envs=2)
    lane = envs.lanes[0]
    envs.close()
    assert not threads() - before
    for use in (lane.ram, lambda: lane.lives, lambda: setattr(lane, "mode", 0)):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            use()


def test_constructions_leave_nothing() -> None:
    """Each environment has 250 KiB and a thread, so the limit detects a leak of a seventieth of one."""

    def construct(count: int) -> None:
        for i in range(count):
            envs = make("pong", 2, obs_type="ram" if i % 2 else "dict")
            if i % 10 == 0:
                envs.reset()
                envs.fork(0, [1])
            if i % 3:
                envs.close()

    gc.collect()
    before_all = threads()
    construct(100)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    construct(300)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak < 2048  # KiB
    assert not threads() - before_all


def test_an_error_in_an_environment_reaches_the_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CoreOptions, "check", lambda *_, **__: None)
    for batch_size, num_threads in ((0, 2), (1, 1)):
        envs = make("freeway", 3, mode=[0, 99, 0], batch_size=batch_size, num_threads=num_threads)
        for _ in range(2):
            with pytest.raises(RuntimeError, match="the mode cannot be selected"):
                play(envs)
            with pytest.raises(gymnasium.error.ResetNeeded):
                envs.step(np.zeros(envs.batch_size, int))
        envs.close()


def test_an_interruption_leaves_it_usable() -> None:
    program = (
        "import signal, numpy as np, atari\n"
        "envs = atari.AtariVectorEnv('pong', 4, num_threads=2)\n"
        "first = envs.reset(seed=0)[0].copy()\n"
        "for delay in (0.01, 0.013, 0.017, 0.02):\n"
        "    try:\n"
        "        signal.setitimer(signal.ITIMER_REAL, delay)\n"
        "        while True:\n"
        "            envs.step(np.zeros(4, int))\n"
        "    except KeyboardInterrupt:\n"
        "        assert np.array_equal(envs.reset(seed=0)[0], first)\n"
        "        envs.step(np.zeros(4, int))\n"
        "print('usable')\n"
    )
    prologue = "import signal\nsignal.signal(signal.SIGALRM, signal.default_int_handler)\n"
    done = subprocess.run([sys.executable, "-c", prologue + program], capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == "usable", done.stderr


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="resident memory is read as on Linux")
def test_ended_episodes_forks_and_snapshots_leave_no_memory() -> None:
    """The test runs in a process of its own, in which no other test has freed memory that could be reused."""
    program = """
import atari, numpy as np
def pages():
    return int(open("/proc/self/statm").read().split()[1])
envs = atari.AtariVectorEnv("breakout", 64, num_threads=2)
envs.reset(seed=0)
actions = np.random.default_rng(0).integers(0, 4, (600, 64))
for step in range(600):
    if step == 100:
        before = pages()
    envs.step(actions[step])
    envs.fork(step % 64, [(step + 1) % 64])
    envs.restore([step % 64], envs.snapshot([(step + 2) % 64]))
print((pages() - before) / 64)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert float(done.stdout) < 1, done.stderr  # a frame is 8 pages, and every fourth environment kept one


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/statm")
def test_a_worker_without_memory_raises_and_does_not_end_the_process() -> None:
    program = """
import resource
from pathlib import Path
import atari

for _ in range(6):  # where memory ends differs from round to round
    envs = atari.AtariVectorEnv("pong", 64, num_threads=4)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used, resource.RLIM_INFINITY))
    held, size = [], 1 << 24
    while size >= 1024:
        try:
            held.append(bytearray(size))
        except MemoryError:
            size //= 2
    try:
        try:
            envs.reset(seed=1)
        finally:
            del held  # Python itself needs memory to handle the error
    except MemoryError as error:
        print("memory", error)
    resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("memory") == 6


def test_many_environments_play_and_are_alike() -> None:
    envs = make("pong", 2048, obs_type="ram")
    first, _ = envs.reset(seed=[7] * 2048)
    assert (first == first[0]).all()
    observation, reward, *_ = envs.step(np.full(2048, 2))
    assert (observation == observation[0]).all()
    assert reward.shape == (2048,)


with_fork = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
pytestmark = pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")


@with_fork
def test_a_forked_process_gets_an_error_and_can_go_on() -> None:
    """With the same environments after `close` and a reset, and with new ones."""

    def use() -> None:
        with pytest.raises(RuntimeError, match="was made before the process was forked"):
            envs.step(np.zeros(3, int))
        envs.close()
        for one in (envs, make()):
            one.reset(seed=0)
            assert one.step(np.zeros(3, int))[1].shape == (3,)

    envs = begun(seed=0)
    assert exit_code(use) == 0
    envs.step(np.zeros(3, int))


@with_fork
def test_a_forked_process_ends_of_itself() -> None:
    """The fork happens while environments are played; the child has none of their threads."""
    envs = begun(num_envs=4, seed=0)
    envs.fork(0, [1, 2, 3])
    envs.send(np.zeros(4, int))
    assert exit_code(gc.collect) == 0
    envs.recv()
    envs.step(np.zeros(4, int))


def exit_code(target: Callable[[], object]) -> int | None:
    """The exit code of a forked process that calls `target`, 1 after an error."""
    child = multiprocessing.get_context("fork").Process(target=target)
    child.start()
    child.join(60)
    code = child.exitcode
    child.kill()
    return code
