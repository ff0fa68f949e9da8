"""Programs that run to their end, for tests of what they print then."""

import subprocess
import sys
import textwrap

REPORTING = "from atari import _emulator\n_emulator.report_leaks()\n"
"""Lets nanobind print the objects of this package that exist when the interpreter has ended."""


def printed_at_end(program: str, *, status: int = 0) -> str:
    """What a program has printed to stderr.

    Raises:
        AssertionError: it ended with another status.
    """
    command = [sys.executable, "-W", "ignore", "-c", textwrap.dedent(program)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == status, done.stderr
    return done.stderr
