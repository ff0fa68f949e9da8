"""Translated code returns to where it was called from, as a hardware shadow stack requires: a frame is run by single
steps, in a process of its own, and every `ret` is compared with the `call` that it belongs to.
"""

import ctypes
import os
import platform
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

pytestmark = pytest.mark.skipif(
    platform.machine() != "x86_64" or sys.platform != "linux", reason="single steps are taken by ptrace on x86-64"
)

TRACEME, PEEKTEXT, CONT, KILL, SINGLESTEP, GETREGS = 0, 1, 7, 8, 9, 12
RIP, RSP = 16, 19  # in the registers of GETREGS
MOST_STEPS = 200_000

CHILD = """
import ctypes, os, signal
from atari_inspection import Console
image = bytes.fromhex("{image}")
console = Console(image, "4K", plain=False, translated=True)
assert console.translated
for _ in range(3):
    console.run_frame()
assert ctypes.CDLL(None).ptrace(0, 0, None, None) == 0
os.kill(os.getpid(), signal.SIGSTOP)
console.run_frame()
os.kill(os.getpid(), signal.SIGSTOP)
os._exit(0)
"""


def image() -> bytes:
    """Short frames: three lines of VSYNC, then a subroutine. The write that ends a frame ends translated code, too."""
    code = bytes.fromhex("A9028500 850285028502 2020F0 A9008500 4C00F0")  # LDA, STA, 3 times WSYNC, JSR, LDA, STA, JMP
    return (code.ljust(0x20, b"\xea") + b"\x60").ljust(0xFFC, b"\xea") + b"\x00\xf0\x00\xf0"


class Traced:
    """A stopped process that is run instruction by instruction."""

    def __init__(self, pid: int) -> None:
        self.pid, self.registers = pid, (ctypes.c_ulonglong * 27)()
        self.ptrace = ctypes.CDLL(None, use_errno=True).ptrace
        self.ptrace.restype = ctypes.c_long
        self.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]

    def look(self) -> tuple[int, int]:
        """The instruction pointer and the stack pointer."""
        assert self.ptrace(GETREGS, self.pid, None, ctypes.addressof(self.registers)) == 0
        return self.registers[RIP], self.registers[RSP]

    def word(self, address: int) -> int:
        return self.ptrace(PEEKTEXT, self.pid, address, None) & 0xFFFF_FFFF_FFFF_FFFF

    def steps(self) -> Iterator[tuple[bytes, int, int]]:
        """Before each step the bytes of the instruction, its address and the stack pointer, until the process stops."""
        for _ in range(MOST_STEPS):
            at, stack = self.look()
            yield self.word(at).to_bytes(8, "little"), at, stack
            assert self.ptrace(SINGLESTEP, self.pid, None, None) == 0
            _, status = os.waitpid(self.pid, 0)
            assert os.WIFSTOPPED(status)
            if os.WSTOPSIG(status) != signal.SIGTRAP:
                return
        pytest.fail("the frame does not end")


def is_call(code: bytes) -> bool:
    if code[0] in (0x3E, 0x41, 0xF2) or 0x40 <= code[0] <= 0x4F:
        return is_call(code[1:] + b"\0")
    return code[0] == 0xE8 or (code[0] == 0xFF and code[1] >> 3 & 7 == 2)


def is_return(code: bytes) -> bool:
    return code[0] in (0xC3, 0xC2) or (code[0] in (0xF2, 0xF3) and code[1] in (0xC3, 0xC2))


def test_every_return_belongs_to_a_call() -> None:
    child = subprocess.Popen([sys.executable, "-c", CHILD.format(image=image().hex())], stderr=subprocess.PIPE)
    try:
        _, status = os.waitpid(child.pid, 0)
        if not os.WIFSTOPPED(status):
            assert child.stderr is not None
            message = child.stderr.read().decode()
            pytest.skip(f"no process may be traced here: {message[-300:]}")
        traced, shadow, returns, called = Traced(child.pid), [], 0, False
        for code, at, stack in traced.steps():
            if called:
                shadow.append(traced.word(stack))
            called = is_call(code)
            if is_return(code) and shadow:  # those of callers that were called before have no entry
                returns += 1
                assert traced.word(stack) == shadow.pop(), f"the return at {at:#x} has no call"
        assert returns > 20
    finally:
        child.kill()
        child.wait()
