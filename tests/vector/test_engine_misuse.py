"""The binding beneath `AtariVectorEnv`, called in ways in which the package does not: an exception each, never a crash."""

from own_process import run_program

SETUP = """
import sys, numpy as np, atari
import atari._emulator as _emulator
from atari.vector.results import Results
from atari.env.settings import filled

def make(num_envs=4, **options):
    envs = atari.AtariVectorEnv("pong", num_envs, **options)
    envs.reset(seed=0)
    return envs

def start(engine, batch, count=4):
    engine.start(np.zeros(count, np.int64), None, batch)

def reset(engine, batch, count=4):
    engine.reset(np.ones(count, bool), np.zeros(count, bool), np.zeros((count, 9), np.uint32), batch)

def batch_of(envs):
    return Results(envs._engine, envs._options).batch

def spec(**changes):
    game = atari.games["pong"]
    native = atari.cores.native.compiled(game, atari.roms.find(game).read_bytes())
    return filled(_emulator.LaneSpec(), game=native, **changes)

def engine_of(spec, **changes):
    episode = filled(_emulator.EpisodeSettings(), **changes)
    return _emulator.VectorEngine([spec], episode, _emulator.ObservationSettings(), _emulator.VectorSettings())

def attempt(name, call):
    global envs, engine
    envs = make()
    engine = envs._engine
    print(name, file=sys.stderr, flush=True)  # Should it crash, its name is the last.
    try:
        call()
    except Exception as error:
        print(f"{name}: {type(error).__name__}")
    else:
        print(f"{name}: accepted")
    envs.reset(seed=0)
    for _ in range(3):
        envs.step(np.zeros(4, int))

envs, small = make(), make(2)
engine = envs._engine
"""

MISUSES = {
    "a start without a batch": ("start(engine, None)", "ValueError"),
    "a reset without a batch": ("reset(engine, None)", "ValueError"),
    "a sequence in a batch of single steps": (
        "engine.play(np.zeros(12, np.int64), None, batch_of(envs), None, 3, 1.0, True, True)",
        "ValueError",
    ),
    "a sequence of no steps": (
        "engine.play(np.zeros(0, np.int64), None, batch_of(envs), None, 0, 1.0, True, False)",
        "ValueError",
    ),
    "a sequence with too few actions": (
        "engine.play(np.zeros(11, np.int64), None, batch_of(envs), None, 3, 1.0, True, False)",
        "ValueError",
    ),
    "a sequence received into another batch": (
        "(engine.play(np.zeros(12, np.int64), None, Results(engine, envs._options, steps=3).batch, None, 3, 1.0, True, "
        "True), engine.receive(batch_of(envs)))",
        "ValueError",
    ),
    "the results of a sequence that is not received": (
        "engine.play(np.zeros(12, np.int64), None, batch_of(envs), None, 3, 1.0, True, False).results[2].sum()",
        "accepted",
    ),
    "a batch of too many steps": ("_emulator.Batch(engine, None, None, 2**40)", "ValueError"),
    "a start into no batch": ("start(engine, 3)", "TypeError"),
    "a start into a batch that is not initialized": (
        "start(engine, _emulator.Batch.__new__(_emulator.Batch))",
        "TypeError",
    ),
    "a start into a batch of a smaller vector": ("start(engine, batch_of(small))", "ValueError"),
    "a reset into a batch of a smaller vector": ("reset(engine, batch_of(small))", "ValueError"),
    "a start into a batch of smaller observations": ("start(engine, batch_of(make(img_height=20)))", "ValueError"),
    "a receive of another batch": ("(start(engine, batch_of(envs)), engine.receive(batch_of(envs)))", "ValueError"),
    "a strength that is no number": (
        "engine.start(np.zeros(4, np.int64), np.full(4, np.nan, np.float32), batch_of(envs))",
        "ValueError",
    ),
    "a loan that is not initialized": (
        "np.ndarray((1,), np.uint8, _emulator.Loan.__new__(_emulator.Loan))",
        "BufferError",
    ),
    "an engine that is initialized again": (
        "engine.__init__([spec()], _emulator.EpisodeSettings(), _emulator.ObservationSettings(), _emulator.VectorSettings())",
        "TypeError",
    ),
    "a batch that is initialized again": (
        "(b := batch_of(envs)).__init__(engine, None, None)",
        "TypeError",
    ),
    "a snapshot that is unpickled into": (
        "(s := envs.snapshot()[0].state).__setstate__(s.__getstate__())",
        "TypeError",
    ),
    "a lane without a game": ("engine_of(_emulator.LaneSpec())", "ValueError"),
    "an action number that ALE does not have": ("engine_of(spec(actions=[18]))", "ValueError"),
    "a negative action number": ("engine_of(spec(actions=[-1]))", "ValueError"),
    "a skip without end": ("engine_of(spec(), frameskip=(2**31 - 2, 2**31 - 1))", "ValueError"),
    "no players": ("engine_of(spec(), players=0)", "ValueError"),
    "more players than there are ports": ("engine_of(spec(), players=5)", "ValueError"),
    "no-ops without end": ("engine_of(spec(), noops=(2**31 - 1, 2**31 - 1))", "ValueError"),
    "a core with a skip without end": (
        "_emulator.Emulator(game=spec().game, repeat_action_probability=0.0, frame_skip=2**31 - 1,"
        " max_num_frames_per_episode=0, sound=False, color_averaging=False, seed=0)",
        "ValueError",
    ),
}


def test_misuses_are_refused_and_the_environment_goes_on() -> None:
    calls = "".join(f"attempt({name!r}, lambda: {call})\n" for name, (call, _) in MISUSES.items())
    assert run_program(SETUP + calls).splitlines() == [f"{name}: {error}" for name, (_, error) in MISUSES.items()]


def test_memory_that_is_being_written_is_not_resized() -> None:
    run_program(
        SETUP
        + """
out = np.zeros((4, 4, 84, 84), np.uint8)
for _ in range(20):
    envs.send(np.zeros(4, int), out)
    try:
        out.resize((1,), refcheck=False)
    except ValueError as error:
        assert "cannot resize" in str(error)
    else:
        raise AssertionError("resized")
    envs.recv()

shape = np.zeros((16, 210, 160), np.uint8)
lender = _emulator.ArrayLender(shape)
view = np.ndarray((16, 210, 160), np.uint8, lender.lend())
try:
    shape.resize((1,), refcheck=False)
except ValueError:
    pass
view[:] = 1
"""
    )
