"""Programs that a test runs in their own interpreter, because their failures are hangs or crashes."""

import subprocess
import sys
import textwrap

LIMIT = 60
"""Seconds after which a program counts as hung. All of them take a few."""


def run_program(program: str) -> str:
    """The program's output; it must end by itself, with status 0 and without an error in any of its threads.

    Raises:
        AssertionError: it hung, crashed, or raised an error; the message has its stderr.
    """
    command = [sys.executable, "-X", "faulthandler", "-W", "ignore::DeprecationWarning", "-c", textwrap.dedent(program)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired as error:
        raise AssertionError(f"the program hung; it printed {error.stdout!r}, and to stderr {error.stderr!r}") from None
    assert done.returncode == 0, f"status {done.returncode}: {done.stderr}"
    assert "Exception in thread" not in done.stderr, done.stderr  # such an error does not change the status
    return done.stdout
