"""A kill at any store, and a loss of power at any time, leave a file of `ReplayMemory` with its last complete flush.

The model of a disk: `sync_map` is patched, and remembers the bytes of the file, which are then on the disk. A loss
of power leaves any of the versions that each page has had since. A kill leaves any prefix of the stores.
"""

import copy
import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from memory_streams import FIELDS, Stream, everything, same
from naive_memory import NaiveMemory

from atari.base import durable
from atari.learning import ReplayMemory

SHAPE = (30, 60)
LANES = 3
PAGE = 4096
SECTIONS = (8192, 8192 + 2 * PAGE)  # a saved state takes two pages
COMPLETED, BEGUN, CHECK = 1, 0, 2  # words of a section's header, in the order in which `begin_save` stores them
MODES = ["next_step", "same_step", "disabled"]


class Played:
    """A memory with a file, and its naive twin."""

    def __init__(self, path: Path, mode: str, **options: Any) -> None:
        finals = 0 if mode == "next_step" else 60
        defaults = {"margin": 12, "final_frames": finals, "seed": 1, "autoflush": False}
        self.mode, self.path = mode, path
        self.memory = ReplayMemory(
            24, LANES, SHAPE, stack_num=2, autoreset_mode=mode, path=path, **{**defaults, **options}
        )
        self.naive = NaiveMemory(24, LANES, SHAPE, 2, "zero", mode)
        self.stream = Stream(LANES, SHAPE, mode, 0.2, 7)
        self.stream.reset(self.memory, self.naive, first=True)
        self.memory.flush()

    def step(self) -> None:
        self.stream.step(self.memory, self.naive)

    def state(self) -> tuple[NaiveMemory, Stream]:
        return copy.deepcopy((self.naive, self.stream))

    def step_and_reopen(self) -> None:
        """Step, flush and close, and check that `open` finds this."""
        self.step()
        self.memory.flush()
        self.memory.close()
        with ReplayMemory.open(self.path) as memory:
            compare(memory, self.naive)


def compare(memory: ReplayMemory, naive: NaiveMemory) -> None:
    assert np.array_equal(memory.observations(), naive.observations())
    for n in (1, 3):
        wanted = naive.transitions(n, 0.9, 2)
        found = everything(memory, n=n, gamma=0.9) if wanted else {}
        assert sorted(found) == [row["indices"] for row in wanted]
        for row in wanted:
            same(found[row["indices"]], row)


def no_space(*_: Any) -> None:
    raise OSError(28, "No space left on device")


class Disk:
    """The versions of a memory's file that the disk may have, and the states that `open` may find in them."""

    def __init__(self, played: Played, monkeypatch: pytest.MonkeyPatch) -> None:
        self.played, self.copy = played, played.path.with_name("copy")
        self.random = np.random.default_rng(0)
        self.versions = [self.bytes()]
        self.states = {played.memory.flushes: played.state()}
        self.drawn: dict[int, Any] = {}  # by flush, the first batch that is sampled after `open`
        self.allowed = {played.memory.flushes}
        self.found: list[int] = []
        monkeypatch.setattr(durable, "sync_map", lambda _: self.synced())

    def bytes(self) -> np.ndarray:
        return np.frombuffer(self.played.path.read_bytes(), np.uint64)

    def flush(self) -> None:
        number = self.played.memory.flushes + 1
        self.states[number] = self.played.state()
        self.allowed = {number - 1, number}
        self.played.memory.flush()
        assert self.played.memory.flushes == number
        self.allowed = {number}
        self.check(self.bytes())

    def see(self) -> None:
        """Try crashes. The disk may get the present version of any page from now on."""
        before, now = self.versions[-1], self.bytes()
        self.versions.append(now)
        for image in [*self.kills(before, now), self.power_cut(), self.power_cut()]:
            self.check(image)

    def synced(self) -> None:
        if not self.trying:
            self.see()
            self.versions = [self.versions[-1]]

    def power_cut(self) -> np.ndarray:
        """An image with one of the versions of each page."""
        versions = np.stack(self.versions).reshape(len(self.versions), -1, PAGE // 8)
        pages = np.arange(versions.shape[1])
        return versions[self.random.integers(0, len(self.versions), len(pages)), pages].reshape(-1)

    def kills(self, before: np.ndarray, now: np.ndarray) -> Iterator[np.ndarray]:
        """Some of the stores: any of those to rows and content, and then those to a header in their order."""
        header = [start // 8 + word for start in SECTIONS for word in (COMPLETED, BEGUN, CHECK)]
        last = [word for word in header if before[word] != now[word]]
        if last and last[-1] * 8 % PAGE == CHECK * 8 and now[last[-1]] != 0:
            last.reverse()  # `complete_save` stores the checksum first
        rest = np.setdiff1d(np.flatnonzero(before != now), header)
        some = rest[self.random.random(len(rest)) < self.random.random()]
        for stores in [some, *(np.append(rest, last[:count]) for count in range(len(last) + 1))]:
            image = before.copy()
            image[stores.astype(int)] = now[stores.astype(int)]
            yield image

    def open(self, image: np.ndarray, **options: Any) -> ReplayMemory:
        self.copy.write_bytes(image.tobytes())
        self.trying = True
        try:
            return ReplayMemory.open(self.copy, **options)
        finally:
            self.trying = False

    def check(self, image: np.ndarray, **options: Any) -> int:
        with self.open(image, **options) as memory:
            number = memory.flushes
            assert number in self.allowed
            batch = memory.sample(9, n=2, beta=0.5 if self.drawn_by_priority else None) if memory.count(2) else None
            values = None if batch is None else [getattr(batch, name).copy() for name in (*FIELDS, "weights")]
            first = self.drawn.setdefault(number, values)
            assert (first is None) == (values is None)
            assert all(np.array_equal(a, b) for a, b in zip(first or [], values or [], strict=True))
            compare(memory, self.states[number][0])
        self.found.append(number)
        return number

    drawn_by_priority = trying = False


@pytest.mark.parametrize("compress", [False, True])
@pytest.mark.parametrize("mode", MODES)
def test_crashes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: str, compress: bool) -> None:
    played = Played(tmp_path / "replay", mode, compress=compress, priority_exponent=0.5 if compress else None)
    disk = Disk(played, monkeypatch)
    disk.drawn_by_priority = compress
    disk.flush()
    for _ in range(4):
        for _ in range(int(disk.random.integers(1, 6))):
            if played.memory.must_flush:
                break
            played.step()
            if compress:
                indices = played.memory.sample(4).indices
                played.memory.update_priorities(indices, disk.random.random(4))
            if disk.random.random() < 0.3:
                disk.see()
        disk.flush()
    assert len(disk.found) > 80
    assert len(set(disk.found)) == 6


@pytest.mark.parametrize("mode", MODES)
def test_a_memory_goes_on_after_a_crash(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: str) -> None:
    played = Played(tmp_path / "replay", mode)
    disk = Disk(played, monkeypatch)
    images: list[np.ndarray] = []
    monkeypatch.setattr(disk, "check", images.append)
    for _ in range(3):
        for _ in range(4):
            played.step()
        disk.flush()
    monkeypatch.setattr(durable, "sync_map", lambda _: None)
    for image in images[:: len(images) // 12]:
        with disk.open(image) as memory:
            naive, stream = copy.deepcopy(disk.states[memory.flushes])
            for _ in range(20):
                stream.step(memory, naive)
            memory.flush()
            number = memory.flushes
        with ReplayMemory.open(disk.copy) as memory:
            assert memory.flushes == number
            compare(memory, naive)


def test_the_flush_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A memory can go on from the flush before the last, which is then forgotten."""
    played = Played(tmp_path / "replay", "same_step")
    disk = Disk(played, monkeypatch)
    for _ in range(3):
        played.step()
        played.step()
        disk.flush()
    number, image = played.memory.flushes, disk.bytes()
    for wrong in (1, number - 2, number + 1):
        with pytest.raises(ValueError, match=f"no flush {wrong}; it has flush {number - 1} and {number}"):
            disk.open(image, flush=wrong)
    disk.allowed = {number - 1, number}
    assert disk.check(image) == number
    assert disk.check(image, flush=number) == number
    assert disk.check(image, flush=number - 1) == number - 1

    played.memory.close()
    played.path.write_bytes(image.tobytes())
    disk.versions = [image]
    played.memory = ReplayMemory.open(played.path, flush=number - 1)  # the patched `sync_map` tries crashes
    disk.synced()
    disk.allowed = {number - 1}
    disk.see()
    played.naive, played.stream = copy.deepcopy(disk.states[number - 1])
    for _ in range(3):
        played.step()
        disk.see()
    disk.drawn.pop(number)
    disk.flush()
    assert played.memory.flushes == number


def test_an_overwritten_flush_is_refused(tmp_path: Path) -> None:
    played = Played(tmp_path / "replay", "next_step")
    for _ in range(20):
        played.step()
        played.memory.flush()
    number = played.memory.flushes
    while not played.memory.must_flush:
        played.step()
    played.memory.close()
    with pytest.raises(ValueError, match=f"steps after flush {number} have overwritten flush {number - 1}: row"):
        ReplayMemory.open(played.path, flush=number - 1)
    with ReplayMemory.open(played.path) as memory:
        assert memory.flushes == number


def test_a_flipped_bit_is_no_older_state(tmp_path: Path) -> None:
    played = Played(tmp_path / "replay", "next_step")
    for _ in range(4):
        played.step()
        played.memory.flush()
    newest = played.memory.flushes
    played.memory.close()
    good = played.path.read_bytes()
    start, refused = SECTIONS[newest % 2], 0
    for bit in [*range(24 * 8), *range(24 * 8, 2 * PAGE * 8, 901)]:
        damaged = bytearray(good)
        damaged[start + bit // 8] ^= 1 << bit % 8
        played.path.write_bytes(damaged)
        try:
            with ReplayMemory.open(played.path) as memory:
                assert memory.flushes == newest, bit
        except ValueError as error:
            refused += f"it has flush {newest - 1}" in str(error)
            with ReplayMemory.open(played.path, flush=newest - 1) as memory:
                assert memory.flushes == newest - 1
            with ReplayMemory.open(played.path) as memory:
                assert memory.flushes == newest - 1
    assert refused > 150


@pytest.mark.parametrize("compress", [False, True])
@pytest.mark.parametrize(("mode", "finals"), [("next_step", 0), ("same_step", 6), ("same_step", 20), ("disabled", 6)])
@pytest.mark.parametrize("margin", [0, 5, 12])
def test_must_flush_says_when(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: str, finals: int, margin: int, compress: bool
) -> None:
    monkeypatch.setattr(durable, "sync_map", lambda _: None)
    least = {"compressed_bytes": 1} if compress else {}
    if compress:
        with pytest.raises(ValueError, match="at least") as error:
            Played(tmp_path / "small", mode, **least)
        least = {"compressed_bytes": int(str(error.value).split("at least ")[1].split()[0])}
    played = Played(tmp_path / "replay", mode, margin=margin, final_frames=finals, **least)
    memory, random = played.memory, played.stream.random
    flushes, refusals, unchanged, zeros = 0, 0, True, np.zeros(LANES, int)
    for _ in range(100):
        before = memory.steps, len(memory), memory.flushes
        if memory.must_flush:
            frames, ended = played.stream.frames(), np.ones(LANES, bool)
            try:
                memory.add(zeros, zeros, ended, ~ended, {"final_obs": frames}, observations=frames)
            except BufferError as refused:
                refusals += f"of flush {before[2]}; call flush() first" in str(refused)
                unchanged = before == (memory.steps, len(memory), memory.flushes)
            memory.flush()
            flushes += 1
            assert not memory.must_flush
            assert unchanged
        ended = random.random(LANES) < 0.5
        frames = random.integers(0, 256, (LANES, *SHAPE), dtype=np.uint8)  # cannot be compressed
        memory.add(zeros, zeros, ended, ~ended & False, {"final_obs": frames}, observations=frames)
        for lane in random.permutation(LANES) if mode != "next_step" else ():
            memory.reset(frames, np.arange(LANES) == lane)
    assert flushes > 3
    assert refusals > 0 or mode == "disabled"  # there `add` alone needs no final observations
    memory.flush()
    number = memory.flushes
    memory.close()
    with ReplayMemory.open(played.path) as memory:
        assert memory.flushes == number


def test_a_memory_flushes_by_itself(tmp_path: Path) -> None:
    """A flush comes before a step that would overwrite the last flush, and not before others."""
    played = Played(tmp_path / "replay", "next_step", autoflush=True)
    for _ in range(60):
        played.step()
    assert 4 <= played.memory.flushes < 30
    played.memory.close()
    ReplayMemory.open(played.path).close()


def test_an_error_of_the_disk_keeps_the_flush_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    played = Played(tmp_path / "replay", "next_step")
    saved = played.state()
    played.step()
    for failing in (1, 2, 3):
        calls = itertools.count(1)

        def sync(_: Any, failing: int = failing, calls: Iterator[int] = calls) -> None:
            if next(calls) == failing:
                raise OSError(5, "the disk is broken")

        monkeypatch.setattr(durable, "sync_map", sync)
        with pytest.raises(OSError, match="broken"):
            played.memory.flush()
        assert played.memory.flushes == 2
        copied = tmp_path / "copy"
        copied.write_bytes(played.path.read_bytes())
        with ReplayMemory.open(copied, flush=2) as memory:
            compare(memory, saved[0])
    monkeypatch.undo()
    played.step_and_reopen()


def test_state_leaves_the_file_as_it_is(tmp_path: Path) -> None:
    played = Played(tmp_path / "replay", "same_step")
    played.memory.flush()
    before, number = played.path.read_bytes(), played.memory.flushes
    state = played.memory.state()
    assert played.path.read_bytes() == before
    assert played.memory.flushes == number
    present = played.state()
    played.step()
    played.memory.restore(state)
    compare(played.memory, present[0])


@pytest.mark.parametrize("operation", ["write", "sync", "sync_map", "replace"])
def test_a_restore_that_fails_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, operation: str) -> None:
    played = Played(tmp_path / "replay", "next_step")
    state = played.memory.state()
    played.step()
    played.memory.flush()
    with monkeypatch.context() as patched:
        patched.setattr(durable, operation, no_space)
        with pytest.raises(OSError, match="No space"):
            played.memory.restore(state)
    assert [path.name for path in tmp_path.iterdir()] == ["replay"]
    compare(played.memory, played.naive)
    played.step_and_reopen()


@pytest.mark.parametrize("operation", ["write", "sync", "sync_folder", "sync_map"])
def test_a_file_that_cannot_be_made_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, operation: str) -> None:
    monkeypatch.setattr(durable, operation, no_space)
    with pytest.raises(OSError, match="No space"):
        ReplayMemory(10, 1, (4, 4), path=tmp_path / "replay")
    assert not list(tmp_path.iterdir())


def test_a_restored_file_goes_on_under_its_name(tmp_path: Path) -> None:
    played = Played(tmp_path / "replay", "next_step")
    state, then = played.memory.state(), played.state()
    played.step()
    target = tmp_path / "target"
    target.write_bytes(b"mine")
    durable.part_of(played.path).symlink_to(target)
    played.memory.restore(state)
    assert target.read_bytes() == b"mine"
    with pytest.raises(BlockingIOError, match="in use"):
        ReplayMemory.open(played.path)
    played.naive, played.stream = then
    played.step_and_reopen()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["replay", "target"]


RESTORING = """
import sys
import numpy as np
from atari.learning import ReplayMemory
memory = ReplayMemory(1000, 2, (84, 84), path=sys.argv[1], seed=0)
no = np.zeros(2, bool)
memory.reset(np.zeros((2, 84, 84), np.uint8))
for step in range(450):
    frames = np.full((2, 84, 84), step % 256, np.uint8)
    memory.add(np.zeros(2, int), np.ones(2), no, no, observations=frames)
state = memory.state()
memory.add(np.zeros(2, int), np.ones(2), no, no, observations=frames)
memory.flush()
print("ready", flush=True)
while True:
    memory.restore(state)
    memory.add(np.zeros(2, int), np.ones(2), no, no, observations=frames)
    memory.flush()
"""


def test_kills_during_a_restore(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    for attempt in range(2):
        path = tmp_path / f"replay{attempt}"
        command = [sys.executable, "-c", RESTORING, str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == b"ready\n"
            time.sleep(0.02 + 0.05 * attempt)
            process.send_signal(signal.SIGKILL)
        with ReplayMemory.open(path) as memory:
            assert memory.steps in (900, 902)


@pytest.mark.parametrize("compress", [False, True])
def test_flushes_do_not_change_what_is_sampled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compress: bool) -> None:
    """Lives of three steps use up the space for final observations; then a flush is due after an eighth of it."""
    monkeypatch.setattr(durable, "sync_map", lambda _: None)
    memories = [
        ReplayMemory(6000, 2, (20,), autoreset_mode="same_step", seed=3, path=tmp_path / name, final_frames=240,
                     compress=compress, margin=600, autoflush=False)
        for name in "ab"
    ]  # fmt: skip
    random, often = np.random.default_rng(0), [0, 0]
    for memory in memories:
        memory.reset(np.zeros((2, 20), np.uint8))
    for step in range(5000):
        frames, ended = random.integers(0, 256, (2, 20), dtype=np.uint8), random.random(2) < 1 / 3
        for number, memory in enumerate(memories):
            if memory.must_flush or (number and step % 7 == 0):
                memory.flush()
                often[number] += 1
            memory.add(np.zeros(2, int), ended, ended, ~ended & False, {"final_obs": frames}, observations=frames)
        if step % 100 == 99:
            one, other = (memory.sample(16, n=3) for memory in memories)
            assert (one.indices == other.indices).all()
            assert (one.next_observations == other.next_observations).all()
    assert len(memories[0]) == len(memories[1]) < 700  # as many steps as have a final observation
    assert often[0] < 5000 * 2 / 3 / (240 / 8 - 4) + 5
