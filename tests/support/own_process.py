"""Programs that a test runs in their own interpreter: their failures are hangs or crashes, or they print at their end."""

import subprocess
import sys
import textwrap

LIMIT = 60
"""Seconds after which a program counts as hung. All of them take a few."""
REPORTING = "from atari import _emulator\n_emulator.report_leaks()\n"
"""Lets nanobind print the objects of this package that exist when the interpreter has ended."""


def ended(program: str, *options: str, limit: int = LIMIT) -> "subprocess.CompletedProcess[str]":
    """A program that has ended by itself.

    Raises:
        AssertionError: it hung; the message has its stderr.
    """
    command = [sys.executable, *options, "-c", textwrap.dedent(program)]
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired as error:
        raise AssertionError(f"the program hung; it printed {error.stdout!r}, and to stderr {error.stderr!r}") from None


def run_program(program: str) -> str:
    """The program's output; it must end by itself, with status 0 and without an error in any of its threads.

    Raises:
        AssertionError: it hung, crashed, or raised an error; the message has its stderr.
    """
    done = ended(program, "-X", "faulthandler", "-W", "ignore::DeprecationWarning")
    assert done.returncode == 0, f"status {done.returncode}: {done.stderr}"
    assert "Exception in thread" not in done.stderr, done.stderr  # such an error does not change the status
    return done.stdout


def printed_at_end(program: str, *, status: int = 0) -> str:
    """What a program has printed to stderr.

    Raises:
        AssertionError: it ended with another status.
    """
    done = ended(program, "-W", "ignore", limit=300)
    assert done.returncode == status, done.stderr
    return done.stderr
