"""`LaneSnapshot`: the state of a lane of a vector, which continues in the single environment of its task, too.

A lane's state has the same parts as the state of a single environment, in another order:

    lane                        single environment
    outcome of the last step    the first byte of the state of its `_emulator.Episode`
    emulator                    the state of the core
    observation                 the state of the `Episode` up to `generator_offset`
    generator                   `Driver.np_random`, with ale-py's seeding `Driver.ale_random`
    the rest                    the rest of the state of the `Episode`

An `AtariEnv` without an `Episode`, of a task that needs none, keeps the score and the counters itself.
"""

import struct
from typing import NamedTuple

import numpy as np

import atari._emulator as _emulator
from atari.cores import NativeCore
from atari.cores.ale_random import AleRandom
from atari.env.driver import Driver
from atari.env.settings import make_episode
from atari.task import Task

_PCG64 = struct.Struct("=4QII")  # atari/emulator/vector/pcg64.hpp


class LaneSnapshot(NamedTuple):
    """The state of a lane, in memory, with the text that `atari.task.json_form.identity` makes from its task."""

    state: _emulator.MemberSnapshot
    task: str


class LaneState(NamedTuple):
    """The parts of a lane's state, as a single environment has them.

    Attributes:
        core: the snapshot of the core.
        episode: the state of the `Episode`.
        np_random, ale_random: the generator of episodes, and None.
    """

    core: bytes
    episode: bytes
    np_random: np.random.Generator | None
    ale_random: AleRandom | None


def new_episode(task: Task, driver: Driver) -> _emulator.Episode:
    """The `Episode` of a single environment, which draws from the driver's generator."""
    return make_episode(task, begin_actions=task.begin_actions, stacked=task.stack_num is not None, draw=driver.draw)


def split(snapshot: LaneSnapshot, task: Task, driver: Driver) -> LaneState:
    """The parts of a lane's state for the single environment of the same task.

    Raises:
        ValueError: the environment is played by ale-py's core, or has another ROM image; the snapshot is damaged.
    """
    core = _native(driver)
    data, emulator, episode = snapshot.state.content(core), len(core.save()), new_episode(task, driver)
    middle, size = emulator + episode.generator_offset, emulator + len(episode.save())
    generator = data[middle : middle + len(data) - size]
    ale = AleRandom.of_state(generator) if driver.ale_random is not None else None
    if ale is None and len(generator) != _PCG64.size:
        raise ValueError("the snapshot is damaged: it has not the size of a lane's state")
    pcg = _of_words(*_PCG64.unpack(generator)) if ale is None else None
    rest = data[1 + emulator : middle] + data[middle + len(generator) :]
    return LaneState(core.snapshot_of(data[1 : 1 + emulator]), data[:1] + rest, pcg, ale)


def join(episode: _emulator.Episode, driver: Driver) -> _emulator.MemberSnapshot:
    """The state of a lane that continues a single environment, whose `Episode` is given.

    Raises:
        ValueError: the environment is played by ale-py's core; its generator is not the one of a lane.
    """
    core, data, offset = _native(driver), episode.save(), episode.generator_offset
    state = data[:1] + core.save() + data[1:offset] + _words(driver) + data[offset:]
    return _emulator.MemberSnapshot.of_bytes(core, state)


def _native(driver: Driver) -> NativeCore:
    core = getattr(driver.emulated, "inner", driver.emulated)  # of a core that is recorded
    if not isinstance(core, NativeCore):
        raise ValueError(
            f"a lane's state continues on the cores 'native' and 'plain', not {core.name!r}; make the environment with "
            "core='native'"
        )
    return core


def _words(driver: Driver) -> bytes:
    if driver.ale_random is not None:
        return driver.ale_random.state()
    state = driver.np_random.bit_generator.state
    if state["bit_generator"] != "PCG64":
        raise ValueError(f"a lane draws from NumPy's PCG64, not {state['bit_generator']}; leave np_random as it was")
    words = [state["state"][name] >> shift & 2**64 - 1 for name in ("state", "inc") for shift in (0, 64)]
    return _PCG64.pack(*words, state["uinteger"], state["has_uint32"])


def _of_words(low: int, high: int, inc_low: int, inc_high: int, kept: int, has_kept: int) -> np.random.Generator:
    generator = np.random.PCG64()
    generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": low | high << 64, "inc": inc_low | inc_high << 64},
        "has_uint32": has_kept,
        "uinteger": kept,
    }
    return np.random.Generator(generator)
