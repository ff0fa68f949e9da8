"""The first module that `import atari` runs: it lets a program of this package end well while it is still imported.

The command `atari` and `python -m atari...` import the package, which takes a second, before a function of it can catch
Ctrl-C. This module imports little itself. In other programs it does nothing.
"""

import os
import signal
import sys
from types import FrameType


def _is_program() -> bool:
    word = sys.orig_argv[-len(sys.argv)] if 0 < len(sys.argv) <= len(sys.orig_argv) else ""
    if sys.argv[:1] == ["-m"]:  # Python imports the package of the module to run; the word is `atari` or `-matari`
        return word.removeprefix("-m").partition(".")[0] == "atari"
    return os.path.splitext(os.path.basename(word))[0] == "atari"


PROGRAM = _is_program()
"""Whether this process is the command `atari`, or `python -m atari` or a module in it."""


def say(line: str) -> None:
    """Write a line to stderr, also in a signal handler, which cannot use a stream."""
    try:  # noqa: SIM105 - contextlib takes longer than all of this module
        os.write(2, f"{line}\n".encode())
    except OSError:  # there is no place to report it
        pass


def leave(number: int = signal.SIGINT, frame: FrameType | None = None) -> None:
    """End at Ctrl-C before or after a command: no file is open for writing, and imports cannot be unwound."""
    say("atari: interrupted")
    os._exit(130)


def open_closed_streams() -> None:
    """Give closed streams the null device.

    Otherwise the next file that is opened would become such a stream, and messages would be written into it.
    """
    for stream in range(3):
        try:
            os.fstat(stream)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # takes the lowest free number


if PROGRAM:
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, leave)
    open_closed_streams()
