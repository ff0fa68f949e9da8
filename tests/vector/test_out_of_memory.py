"""Workers of the vector engine that find no memory: the error reaches the caller, and the process lives."""

import subprocess
import sys

import pytest

pytest.importorskip("resource")  # POSIX

PROGRAM = """
import resource
from pathlib import Path
import atari

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
    envs.reset(seed=1)
except MemoryError as error:
    del held
    print("memory", error)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/statm")
def test_a_worker_without_memory_raises_and_does_not_end_the_process() -> None:
    for _ in range(6):  # where memory ends differs from run to run
        done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        assert done.stdout.startswith("memory")
