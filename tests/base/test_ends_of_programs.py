"""Programs of many kinds run to their end, and nothing of this package is left then.

nanobind would print what is left. Users do not see it, because what they or other libraries hold until the end is no
leak. Here it is printed, but for programs that hold objects on purpose.
"""

import pytest
from own_process import REPORTING, printed_at_end

ENDS = {
    "objects of many kinds": """
        import atari, copy, numpy as np, pickle, tempfile
        import atari.classic as gym
        from atari.lab import Freeze, Poke, RamLabels, Watch
        from atari.learning import ReplayMemory
        from atari.multiplayer import env as aec_env, parallel_env
        from atari.recording import RecordReplay, RecordVideo, Replay
        env = atari.make("pong", preset="dqn2015")
        watch = Watch(RamLabels(atari.AtariEnv("pong")), "ball_x", each="frame")
        old = gym.make("Pong-v0")
        folder = tempfile.mkdtemp()
        recorder = RecordReplay(RecordVideo(atari.AtariEnv("pong"), folder), f"{folder}/a.a26r")
        games = [aec_env("pong_v3"), parallel_env("joust", preset="multiplayer_dqn")]
        for one in (env, watch, old, recorder, *games):
            one.reset()
        held = Freeze(watch, ball_x=90), Poke(watch, {"ball_x": 80}, frame=3)
        for one in (env, watch, old, recorder):
            one.step(0)
        recorder.stop()
        replay = Replay.load(f"{folder}/a.a26r")
        assert replay.verify()
        envs = atari.AtariVectorEnv("pong", 2, stack_num=1)
        copies = [copy.deepcopy(envs), pickle.loads(pickle.dumps(atari.cores.NativeCore("pong")))]
        memory = ReplayMemory.for_env(envs, 100)
        memory.reset(envs.reset(seed=0)[0])
        for _ in range(30):
            actions = np.zeros(2, int)
            _, *results = envs.step(actions, out=memory.frames())
            memory.add(actions, *results)
        batches = [memory.sample(4) for _ in range(3)]
        own = memory.make_batch(4)
        memory.sample(4, out=own)
    """,
    "games of all kinds": """
        import atari
        cores = [atari.cores.NativeCore(game) for game in list(atari.games)[:20]]
        states = [core.clone_state() for core in cores]
        names = [atari.lab.Ram(core) for core in cores if core.game.ram_labels]
        values = [ram[next(iter(ram._labels))] for ram in names]
    """,
    "a cycle of references": """
        import atari, gc
        gc.disable()
        env, envs = atari.AtariEnv("pong"), atari.AtariVectorEnv("pong", 2)
        env.itself, envs.itself, env.reset_again = env, envs, env.reset
        del env, envs
    """,
    "threads that have ended, and a vector that plays": """
        import atari, numpy as np
        from concurrent.futures import ThreadPoolExecutor
        def play(seed):
            env = atari.AtariEnv("pong")
            env.reset(seed=seed)
            return [env.step(0)[1] for _ in range(10)]
        with ThreadPoolExecutor(4) as pool:
            results = list(pool.map(play, range(8)))
        envs = atari.AtariVectorEnv("breakout", 4, num_threads=3)
        observations, info = envs.reset(seed=0)
        envs.send(np.zeros(4, int))
    """,
    "a function that is called at the end": """
        import atari, atexit
        envs = atari.AtariVectorEnv("pong", 2)
        envs.reset(seed=0)
        atexit.register(lambda: envs.step([0, 0]))
    """,
    "child processes": """
        import atari, multiprocessing
        env = atari.AtariEnv("pong")
        env.reset(seed=0)
        child = multiprocessing.get_context("fork").Process(target=env.step, args=(0,))
        child.start()
        child.join()
    """,
}
"""Programs that hold their objects in variables at their end."""


@pytest.mark.parametrize("name", ENDS)
def test_nothing_is_left(name: str) -> None:
    program = REPORTING + "".join(line.removeprefix("        ") + "\n" for line in ENDS[name].splitlines())
    assert printed_at_end(program) == ""


def test_the_report_finds_what_is_left() -> None:
    """A capsule of ctypes is never released."""
    program = """
        import atari._emulator as _emulator
        _emulator.report_leaks()
        import atari, ctypes
        core = atari.cores.NativeCore("pong")
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(core))
    """
    assert "leaked" in printed_at_end(program)


HELD = {
    "a reference that C code holds": """
        import atari, ctypes
        core = atari.cores.NativeCore("pong")
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(core))
    """,
    "daemon threads that play an environment and a vector": """
        import atari, threading
        def play(envs, actions, started):
            envs.reset(seed=0)
            while True:
                envs.step(actions)
                started.set()
        env, begun = atari.AtariEnv("pong"), [threading.Event(), threading.Event()]
        threading.Thread(target=play, args=(env, 0, begun[0]), daemon=True).start()
        made = lambda: play(atari.AtariVectorEnv("pong", 4, num_threads=2), [0] * 4, begun[1])
        threading.Thread(target=made, daemon=True).start()
        for started in begun:
            started.wait()
    """,
}
"""Programs that hold objects for ever: Python leaves the stack of a daemon thread as it is."""


@pytest.mark.parametrize("name", HELD)
def test_nothing_is_printed_of_what_a_program_holds_for_ever(name: str) -> None:
    assert printed_at_end(HELD[name]) == ""


def test_an_error_is_all_that_is_printed() -> None:
    program = REPORTING + (
        "import atari\nenv = atari.AtariEnv('pong')\nenvs = atari.AtariVectorEnv('pong', 2, num_threads=2)\n"
        "envs.reset(seed=0)\nenv.step(99)\n"
    )
    lines = printed_at_end(program, status=1).splitlines()
    assert lines[0] == "Traceback (most recent call last):"
    assert lines[-1].startswith("gymnasium.error.ResetNeeded") or "99" in lines[-1]
    assert not any("nanobind" in line for line in lines)


def test_an_exit_in_the_middle_prints_nothing() -> None:
    program = REPORTING + (
        "import atari, sys\nenvs = atari.AtariVectorEnv('pong', 2, num_threads=2)\nenvs.reset(seed=0)\nsys.exit(3)\n"
    )
    assert printed_at_end(program, status=3) == ""
