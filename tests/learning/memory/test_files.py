"""The file of a `ReplayMemory`: saved states survive a kill, and damaged files are refused."""

import hashlib
import json
import os
import signal
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from memory_streams import FIELDS, Stream, everything

from atari.learning import ReplayMemory

SHAPE = (4, 6)
WORKER = """
import sys
import numpy as np
from memory_streams import Stream
from atari.learning import ReplayMemory

memories = []
for path in sys.argv[1:]:
    mode, compress = path.split("-")[-2:]
    memory = ReplayMemory(200, 2, (4, 6), autoreset_mode=mode, priority_exponent=0.6, seed=3, compress=compress == "1",
                          final_frames=200, path=path, margin=100)
    stream = Stream(2, (4, 6), mode, 0.1, 5)
    stream.reset(memory)
    for step in range(330):
        stream.step(memory)
    memory.update_priorities(memory.sample(32, beta=0.4).indices, stream.random.random(32))
    memory.flush()
    wanted = memory.sample(64, n=3, beta=0.5)
    np.savez(path + ".npz", **{name: getattr(wanted, name) for name in %r + ("weights",)}, present=memory.observations())
    flushes = memory.flushes
    for step in range(40):
        stream.step(memory)
        memory.update_priorities(memory.sample(8).indices, stream.random.random(8))
    assert memory.flushes == flushes
    memories.append(memory)
print("ready", flush=True)
while True:
    for memory in memories:
        memory.frames()[...] = 255
        memory.update_priorities(memory.sample(8).indices, stream.random.random(8))
"""


def test_a_killed_process_leaves_the_states_of_its_last_flushes(tmp_path: Path) -> None:
    paths = [tmp_path / f"replay-{mode}-{int(compress)}" for mode, compress in BYTES]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", WORKER % (FIELDS,), *map(str, paths)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        with pytest.raises(BlockingIOError, match="in use"):
            ReplayMemory.open(paths[0])
        process.send_signal(signal.SIGKILL)
    for path in paths:
        memory, expected = ReplayMemory.open(path), np.load(f"{path}.npz")
        assert np.array_equal(memory.observations(), expected["present"])
        assert_equal(memory.sample(64, n=3, beta=0.5), expected.__getitem__)
        memory.close()


def assert_equal(batch: Any, expected: Callable[[str], Any]) -> None:
    for name in (*FIELDS, "weights"):
        assert np.array_equal(getattr(batch, name), expected(name)), name


def play(memory: ReplayMemory, steps: int) -> None:
    stream = Stream(2, SHAPE, "same_step", 0.2, 9)
    for _ in range(steps):
        stream.step(memory)


def make(path: Path, compress: bool = False) -> ReplayMemory:
    options: dict[str, Any] = {"stack_num": 2, "autoreset_mode": "same_step", "priority_exponent": 1.0, "seed": 1}
    memory = ReplayMemory(30, 2, SHAPE, **options, compress=compress, final_frames=8, path=path, margin=4)
    stream = Stream(2, SHAPE, "same_step", 0.05, 2)
    stream.reset(memory)
    for _ in range(40):
        stream.step(memory)
    memory.flush()
    return memory


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """The file of a closed memory."""
    make(tmp_path / "replay").close()
    return tmp_path / "replay"


def test_reopened_memory_goes_on(path: Path, tmp_path: Path) -> None:
    reopened, twin = ReplayMemory.open(path), make(tmp_path / "twin")
    for one in (reopened, twin):
        play(one, 50)
    second = twin.sample(50, n=2, beta=1.0)
    assert_equal(reopened.sample(50, n=2, beta=1.0), lambda name: getattr(second, name))


@pytest.mark.parametrize("compress", [False, True])
def test_damage_is_an_error_or_harmless(tmp_path: Path, compress: bool) -> None:
    """A changed byte anywhere in the file is noticed, or the memory is the same as before."""
    path = tmp_path / "replay"
    memory = make(path, compress)
    wanted = everything(memory, n=2)
    memory.close()
    good = path.read_bytes()
    used = [i for i in range(0, len(good)) if good[i]]
    random = np.random.default_rng(0)
    places = [*range(0, 300, 7), *random.choice(used, 150), *random.integers(0, len(good), 50)]
    errors = 0
    for place in places:
        damaged = bytearray(good)
        damaged[place] ^= 1 << int(random.integers(8))
        path.write_bytes(damaged)
        try:
            reopened = ReplayMemory.open(path)
        except ValueError as error:
            errors += str(path) in str(error)
            continue
        found = everything(reopened, n=2)
        assert found.keys() == wanted.keys()
        for index, row in found.items():
            for name in FIELDS:
                assert np.array_equal(row[name], wanted[index][name]), (place, name)
        reopened.close()
    assert errors > len(places) // 2


@pytest.mark.parametrize("compress", [False, True])
def test_unverified_damage_does_no_harm(tmp_path: Path, compress: bool) -> None:
    path = tmp_path / "replay"
    make(path, compress).close()
    good = path.read_bytes()
    random = np.random.default_rng(1)
    for _ in range(80):
        damaged = bytearray(good)
        start = int(random.integers(8192, len(good)))
        damaged[start : start + 64] = random.bytes(len(damaged[start : start + 64]))
        path.write_bytes(damaged)
        try:
            memory = ReplayMemory.open(path, verify=False)
        except ValueError:
            continue
        memory.sample(64, n=3)
        memory.sample_sequences(8, 5)
        memory.close()


@pytest.mark.parametrize("size", [0, 1, 100, 8191, 8192, 20000, -1])
def test_a_file_of_another_size_is_refused(path: Path, size: int) -> None:
    good = path.read_bytes()
    path.write_bytes(good[:size])
    with pytest.raises(ValueError, match=r"replay"):
        ReplayMemory.open(path)
    path.write_bytes(good + b"x")
    with pytest.raises(ValueError, match="should have"):
        ReplayMemory.open(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_other_files_are_refused_at_once(path: Path, tmp_path: Path) -> None:
    with pytest.raises(FileExistsError):
        ReplayMemory(10, 1, SHAPE, path=path)
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(path)
    (tmp_path / "text").write_bytes(b"x" * 100_000)
    for other, error, text in (
        (tmp_path / "text", ValueError, "no replay memory"),
        (tmp_path / "other", FileNotFoundError, "no file"),
        (tmp_path, IsADirectoryError, "folder"),
        (tmp_path / "pipe", ValueError, "a device or a pipe"),
        (Path("/dev/zero"), ValueError, "a device or a pipe"),
        (tmp_path / "link", ValueError, "symbolic link"),
    ):
        with pytest.raises(error, match=text):
            ReplayMemory.open(other)


FORGED = [
    ({"capacity": 10**18}, "capacity"),
    ({"capacity": 2**70}, "out of range"),
    ({"num_envs": 2**40}, "num_envs"),
    ({"observation_shape": {"": [2**40]}}, "observation_shape"),
    ({"observation_shape": {"": [2**20, 2**20]}}, "observation_shape"),
    ({"observation_shape": {"": [[4]]}}, "observation_shape"),
    ({"observation_shape": [4, 6]}, "must be a table"),
    ({"margin": 2**40, "final_frames": 2**40}, "larger than"),
    ({"stack_num": {"": 2**40}}, "stack_num"),
    ({"margin": 2**39}, "should have"),
    ({"final_frames": 2**39}, "should have"),
    ({"final_frames": None}, "must be a whole number"),
    ({"priority_exponent": 1e30}, "priority_exponent"),
    ({"priority_exponent": None}, "earlier version|version"),
    ({"action_dtype": "(2**30)i8"}, "action_dtype"),
    ({"action_dtype": "O"}, "action_dtype"),
    ({"action_shape": [2**26]}, "action"),
    ({"capacity": True}, "must be a whole number"),
    ({"more": 1}, "has no key 'more'"),
]


@pytest.mark.parametrize(("change", "match"), FORGED)
def test_forged_options(path: Path, change: dict, match: str) -> None:
    """Options that another program wrote, with the right checksum, are refused before memory is taken for them."""
    good = path.read_bytes()
    length = int.from_bytes(good[16:20], sys.byteorder)
    text = json.dumps({**json.loads(good[24 : 24 + length]), **change}).encode()
    write_header(path, good, text)
    with pytest.raises(ValueError, match=match):
        ReplayMemory.open(path)


@pytest.mark.parametrize("text", [b"[" * 5000, b"null", b"{}", b'{"capacity": NaN}', b"\xff", b'{"a": 1, "a": 2}', b""])
def test_options_that_are_no_table(path: Path, text: bytes) -> None:
    write_header(path, path.read_bytes(), text)
    with pytest.raises(ValueError, match="replay: "):
        ReplayMemory.open(path)


def write_header(path: Path, good: bytes, text: bytes, magic: bytes | None = None) -> None:
    rest = text.ljust(8192 - 24, b"\0")
    start = struct.pack("=16sII", magic or good[:16], len(text), zlib.crc32(rest))
    path.write_bytes(start + rest + good[8192:])


def test_a_memory_with_priorities_of_the_first_version_is_refused(path: Path, tmp_path: Path) -> None:
    good = path.read_bytes()
    length = int.from_bytes(good[16:20], sys.byteorder)
    assert good.startswith(b"atari-replay-2")
    write_header(path, good, good[24 : 24 + length], good[:16].replace(b"2", b"1"))
    with pytest.raises(ValueError, match="with priorities of an earlier version"):
        ReplayMemory.open(path)
    ReplayMemory(10, 1, SHAPE, path=tmp_path / "uniform").close()
    assert (tmp_path / "uniform").read_bytes().startswith(b"atari-replay-1")


def test_an_unfinished_file_is_refused(path: Path) -> None:
    good = path.read_bytes()
    path.write_bytes(good[:8192] + bytes(len(good) - 8192))
    with pytest.raises(ValueError, match="has no saved state: the process that made it ended too early"):
        ReplayMemory.open(path)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows does not cut a mapped file")
def test_a_file_that_is_cut_while_it_is_open(tmp_path: Path) -> None:
    """Access to the pages that are gone would end the process."""
    path = tmp_path / "replay"
    memory = make(path)
    os.truncate(path, 4096)
    frames, none = np.zeros((2, *SHAPE), np.uint8), np.zeros(2, bool)
    for call in (
        lambda: memory.sample(4),
        lambda: memory.sample_sequences(4, 2),
        lambda: memory.add(np.zeros(2, int), np.zeros(2), none, none, observations=frames),
        lambda: memory.reset(frames),
        lambda: memory.update_priorities(np.array([60]), np.ones(1)),
        *(memory.frames, memory.observations, memory.flush, memory.state),
    ):
        with pytest.raises(OSError, match="was cut to 4096 of"):
            call()
    memory.close()


def test_an_open_file_is_locked(tmp_path: Path) -> None:
    path = tmp_path / "replay"
    memory = make(path)
    with pytest.raises(BlockingIOError, match="in use"):
        ReplayMemory.open(path)
    frames = memory.frames()
    memory.close()
    ReplayMemory.open(path).close()
    frames[...] = 1  # the array is still memory
    with pytest.raises(ValueError, match="closed"):
        memory.sample(1)


def test_a_full_disk_is_an_error_at_creation(tmp_path: Path) -> None:
    path = tmp_path / "replay"
    with pytest.raises(OSError, match="on the disk"):
        ReplayMemory(2**24, 1, (1024, 1024), path=path)
    assert not path.exists()


def test_a_state_restores_a_memory(tmp_path: Path) -> None:
    memory = make(tmp_path / "replay")
    state = memory.state()
    first = memory.sample(40, n=2, beta=0.3)
    play(memory, 20)
    memory.restore(state)
    assert_equal(memory.sample(40, n=2, beta=0.3), lambda name: getattr(first, name))
    with pytest.raises(ValueError, match="block"):
        memory.restore({**state, "block": state["block"][:-1]})
    broken = state["block"].copy()
    broken[20] ^= 1
    with pytest.raises(ValueError, match="damaged"):
        memory.restore({**state, "block": broken})


BYTES = {
    ("next_step", False): "d329cc1998d028f5",
    ("next_step", True): "2e5bc394e141e54e",
    ("same_step", False): "8afd236442784532",
    ("same_step", True): "5cdd7f1cb531e0e3",
    ("disabled", False): "b38c8a8b33340c28",
    ("disabled", True): "5beaf48af27d2b9d",
}
"""The beginning of the SHA-256 of files that the first version of the format wrote, on a little-endian machine."""


@pytest.mark.parametrize(("mode", "compress"), BYTES)
def test_the_format_of_files_stays(tmp_path: Path, mode: str, compress: bool) -> None:
    path = tmp_path / "replay"
    options: dict[str, Any] = {"stack_num": 2, "autoreset_mode": mode, "compress": compress}
    memory = ReplayMemory(20, 2, SHAPE, **options, seed=1, path=path, margin=20)

    def frames(first: int) -> np.ndarray:
        return np.arange(first, first + 48, dtype=np.uint8).reshape(2, *SHAPE)

    memory.reset(frames(0))
    for row in range(15):
        ended, no = np.array([row == 5, row == 9]), np.zeros(2, bool)
        info = {"final_obs": frames(100 + row)}
        actions, rewards = np.array([row, 2 * row]), np.array([row, 0.5])
        memory.add(actions, rewards, ended, no, info, observations=frames(row + 1))
        if mode == "disabled" and ended.any():
            memory.reset(frames(200 + row), ended)
        if row == 7:
            memory.flush()
    memory.flush()
    memory.close()
    assert hashlib.sha256(path.read_bytes()).hexdigest()[:16] == BYTES[mode, compress]
