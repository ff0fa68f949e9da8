"""Snapshots with a valid checksum whose blobs were changed: ValueError, and everything as it was.

The checksum is no signature: a program that writes any snapshot can compute it.
"""

import random
import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from typing import Any

import pytest
from env_tools import started

import atari
from atari import AtariVectorEnv
from atari.cores import AleCore, Core, NativeCore, snapshot
from atari.env.lane_snapshot import LaneSnapshot


def with_blob(data: bytes, name: str, blob: bytes) -> bytes:
    facts, blobs = snapshot.unpack(data)
    return snapshot.pack(facts, {**blobs, name: blob})


def check(target: Any, forged: Iterator[bytes], at_least: int) -> None:
    """Each is refused with ValueError, which changes nothing, or is a state like any other."""
    good = target.snapshot()
    refused = 0
    for data in forged:
        try:
            target.restore(data)
        except ValueError:
            assert target.snapshot() == good
            refused += 1
        else:
            if target.snapshot() != good:
                target.restore(good)
    assert refused >= at_least


def core_of(kind: Callable[..., Core], **options: Any) -> Core:
    core = kind("breakout", **options)
    core.reset()
    for _ in range(5):
        core.act(1)
    return core


def other_lengths(data: bytes) -> Iterator[bytes]:
    """Snapshots whose body is a byte too short or too long, or says that its facts are as long as can be."""
    for body in (data[26:-1], data[26:] + b"?", struct.pack("<I", 2**32 - 1) + data[30:]):
        yield data[:10] + snapshot._digest(body) + body


@pytest.mark.parametrize("make", [started, partial(core_of, NativeCore), partial(core_of, AleCore)])
def test_a_body_of_another_length(make: Callable[..., Any]) -> None:
    """What their facts may be is in `tests/base/test_hostile_json.py`."""
    target = make()
    check(target, other_lengths(target.snapshot()), 3)


def test_the_native_state() -> None:
    core = core_of(NativeCore)
    good = core.snapshot()
    state = zlib.decompress(snapshot.unpack(good)[1]["state"])
    rng = random.Random(0)

    def states() -> Iterator[bytes]:
        yield b""
        yield zlib.compress(state)[:-5]
        yield zlib.compress(bytes(10**7))
        for _ in range(20):
            yield zlib.compress(state[: rng.randrange(len(state))])
        for _ in range(300):
            changed = bytearray(state)
            for _ in range(rng.choice([1, 3, 300])):
                changed[rng.randrange(len(state))] = rng.choice([0, 0x7F, 0x80, 0xFF, rng.randrange(256)])
            yield zlib.compress(changed, 1)

    check(core, (with_blob(good, "state", blob) for blob in states()), 25)


def test_the_journal_of_ale_py() -> None:
    core = core_of(AleCore)
    good = core.snapshot()
    nan, huge = struct.pack("<f", float("nan")), struct.pack("<f", 1e30)
    events = [b"\x12", b"\x3f", b"\xff", b"\x40", b"\x40\x12" + bytes(4), b"\x40\x00" + nan, b"\x40\x01" + huge]
    events += [b"\x40\x01\x00", b"\x42", b"\x42\x00", b"\x42\x80\x00", b"", b"\x41", b"\x01" * 9]
    check(core, (with_blob(good, "events", event) for event in events), len(events))
    check(core, iter([with_blob(good, "digest", b""), with_blob(good, "digest", bytes(16))]), 2)
    base = snapshot.unpack(good)[1]["base"]
    bases = [b"", b"?", bytes(len(base)), base[:-1], base[: len(base) // 2], b"\xff" * len(base)]
    check(core, (with_blob(good, "base", state) for state in bases), 3)


def test_snapshots_of_a_vector() -> None:
    envs = AtariVectorEnv("breakout", 2, num_threads=1)
    envs.reset(seed=0)
    good = envs.snapshot()
    state, image = good[0].state.__getstate__()
    rng = random.Random(0)

    def forged(state: bytes, image: int) -> Any:
        snapshot = type(good[0].state).__new__(type(good[0].state))
        snapshot.__setstate__((state, image))
        return snapshot

    def states() -> Iterator[Any]:
        yield forged(b"", image)
        yield forged(state[:-1], image)
        yield forged(state + b"?", image)
        yield forged(state, image ^ 1)
        yield from (LaneSnapshot(good[0].state, text) for text in ("", "{}", "[" * 99, good[0].task[:-9]))
        yield None
        yield b"?"
        for _ in range(200):
            changed = bytearray(state)
            for _ in range(rng.choice([1, 3, 300])):
                changed[rng.randrange(len(state))] = rng.choice([0, 0x7F, 0x80, 0xFF, rng.randrange(256)])
            yield forged(bytes(changed), image)

    before = [each.state.__getstate__() for each in good]
    refused = 0
    for each in states():
        try:
            envs.restore(None, [good[0], each])
        except (TypeError, ValueError):
            refused += 1
            assert [each.state.__getstate__() for each in envs.snapshot()] == before
        else:
            with suppress(ValueError):
                envs.step([1, 1])  # type: ignore[arg-type]
            envs.restore(None, good)
    assert refused >= 7
    envs.close()


def test_snapshots_of_lanes_in_single_environments_and_back() -> None:
    task = atari.Task.of("breakout", preset="dqn2015")
    envs, env = AtariVectorEnv(task, 1, num_threads=1), atari.make(task)
    envs.reset(seed=0)
    env.reset(seed=1)
    (good,) = envs.snapshot()
    state, image = good.state.__getstate__()
    saved, rng = env.snapshot(), random.Random(0)

    def of(data: bytes) -> LaneSnapshot:
        made = type(good.state).__new__(type(good.state))
        made.__setstate__((data, image))
        return LaneSnapshot(made, good.task)

    forged = [of(b""), of(state[:-1]), of(state + b"?"), LaneSnapshot(good.state, "{}")]
    for _ in range(200):
        changed = bytearray(state)
        for _ in range(rng.choice([1, 3, 300])):
            changed[rng.randrange(len(state))] = rng.choice([0, 0x7F, 0x80, 0xFF, rng.randrange(256)])
        forged.append(of(bytes(changed)))
    refused = 0
    for each in forged:
        try:
            env.restore(each)
        except ValueError:
            refused += 1
            assert env.snapshot() == saved
            continue
        changed_bytes = env.snapshot()
        with suppress(ValueError):
            env.step(1)
        with suppress(ValueError):
            envs.restore([0], [changed_bytes])
            envs.step([1])
        env.restore(saved)
    assert refused >= 4
