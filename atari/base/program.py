"""The run of a command of this package: its streams, Ctrl-C, and how it ends."""

import _thread
import contextlib
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any, TextIO, cast

from atari.base.start import leave, say

_SAME = 1.0
"""Seconds after a Ctrl-C in which another one is ignored: a held key must not cut off the removal of partial files."""


def end_imports() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again, in a program that runs a user's script."""
    if signal.getsignal(signal.SIGINT) is leave:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def run(command: Callable[[], int], traceback: bool = False) -> int:
    """Run a command and return the exit code of its process: 130 after Ctrl-C.

    Args:
        command: a function that returns the exit code. It prints to `sys.stdout`, and plays in `interruptible`.
        traceback: raise the errors of the library; otherwise their message is printed in one line, with exit code 1.
    """
    if sys.stdout is None or sys.stdout.closed:
        say("atari: error: stdout is closed, and the result goes there; redirect it to a file, or to /dev/null")
        return 1
    if hasattr(sys.stdout, "reconfigure") and sys.stdout.errors == "strict":
        sys.stdout.reconfigure(errors="backslashreplace")  # a file's name can contain bytes that are no text
    with open(os.devnull) as nothing, open(os.devnull, "w") as nowhere, contextlib.ExitStack() as stack:
        stack.callback(setattr, sys, "stdin", sys.stdin)
        sys.stdin = sys.stdin or nothing
        stack.enter_context(contextlib.redirect_stdout(cast(TextIO, _Output(sys.stdout))))
        stack.enter_context(contextlib.redirect_stderr(cast(TextIO, _Messages(sys.stderr or nowhere))))
        return _code_of(command, traceback)


def _code_of(command: Callable[[], int], traceback: bool) -> int:
    _said.clear()
    try:
        code = command()
        sys.stdout.flush()  # a closed pipe raises here, not at the interpreter's exit
        return code
    except _OutputError as failure:
        _abandon(1, sys.stdout)
        if isinstance(failure.error, BrokenPipeError):  # `atari info | head -1`: the reader has closed the pipe
            return 0
        print_error(OSError(failure.error.errno, failure.error.strerror, "stdout"))
        return 1
    except KeyboardInterrupt as interrupt:
        if interrupt.args or not _said:
            print(" ".join(("atari: interrupted", *map(str, interrupt.args))), file=sys.stderr)
        return 130
    except Exception as error:
        if _said:  # an import that Ctrl-C has cut off raises an error of its own
            return 130
        import gymnasium

        errors = FloatingPointError, MemoryError, OSError, RuntimeError, ValueError, gymnasium.error.Error
        if traceback or not isinstance(error, errors):
            raise
        print_error(error)
        return 1


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Let Ctrl-C say at once that it was heard, and raise KeyboardInterrupt, after an import that is going on.

    A library of C++ whose import is cut off may end the process.
    """

    def interrupt(frame: FrameType | None) -> None:
        while frame is not None and "importlib._bootstrap" not in frame.f_code.co_filename:
            frame = frame.f_back
        if frame is None:
            raise KeyboardInterrupt
        _interrupt_again()

    def raise_again(unraisable: Any) -> None:
        if isinstance(unraisable.exc_value, KeyboardInterrupt):  # raised where Python drops it, as in a finalizer
            _interrupt_again()  # a handler that runs in this hook is dropped, too
        else:
            dropped(unraisable)

    dropped, sys.unraisablehook = sys.unraisablehook, raise_again
    try:
        with _on_ctrl_c("atari: interrupted", interrupt):
            yield
    finally:
        sys.unraisablehook = dropped


@contextlib.contextmanager
def ctrl_c_as_event(line: str = "atari: stopping; Ctrl-C again stops at once") -> Iterator[threading.Event]:
    """Say so and set an event at the first Ctrl-C, so that work ends between two steps. A second acts as usual."""
    interrupted = threading.Event()
    before = signal.getsignal(signal.SIGINT)

    def set_event(_: FrameType | None) -> None:
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    with _on_ctrl_c(line, set_event):
        yield interrupted


@contextlib.contextmanager
def removed_at_ctrl_c(path: Path) -> Iterator[None]:
    """Remove a file whose writing Ctrl-C cuts off."""
    try:
        yield
    except KeyboardInterrupt:
        path.unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def children_without_ctrl_c() -> Iterator[None]:
    """Start child processes that Ctrl-C does not end: their parent ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_said: dict[str, float] = {}
"""The lines about Ctrl-C that this command has printed, with their times."""


@contextlib.contextmanager
def _on_ctrl_c(line: str, act: Callable[[FrameType | None], None]) -> Iterator[None]:
    """Print a line, once, and call a function at Ctrl-C. A process that ignores it stays so."""

    def handle(_: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if now - max(_said.values(), default=-math.inf) > _SAME:
            if line not in _said:
                say(line)
            _said[line] = now
            act(frame)

    before = signal.getsignal(signal.SIGINT)
    if before is signal.SIG_IGN or threading.current_thread() is not threading.main_thread():
        yield
        return
    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _interrupt_again() -> None:
    """Let Ctrl-C act once more, when the main thread has gone on a little."""
    _said.update(dict.fromkeys(_said, -math.inf))
    again = threading.Timer(0.05, _signal_main_thread)
    again.daemon = True
    again.start()


def _signal_main_thread() -> None:
    """Send Ctrl-C to the main thread: `interrupt_main` alone would not wake it from a wait."""
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, signal.SIGINT)
    else:
        _thread.interrupt_main()


def print_exact(text: str) -> None:
    """Print what other programs read, such as JSON, a diff or a script: a terminal gets its lines as they are."""
    getattr(sys.stdout, "write_exact", sys.stdout.write)(text)
    sys.stdout.flush()


def print_error(error: Exception) -> None:
    """Print the message of an exception to stderr, in one line and without errno."""
    if isinstance(error, OSError) and error.strerror:
        sentence = error.strerror + (f": {error.filename}" if error.filename else "")
    else:
        sentence = " ".join(str(error).split())
    print(f"atari: error: {_escaped(sentence)}", file=sys.stderr)


class _OutputError(Exception):
    """Stdout cannot be written. It is no OSError, which commands take for the fault of a file."""

    def __init__(self, error: OSError) -> None:
        super().__init__(str(error))
        self.error = error


class _Messages:
    """Stderr; a terminal gets lines of whole words.

    Messages that cannot be written are dropped, because there is no place to report it.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        from atari.base.text_table import for_terminal

        return self._write(for_terminal(text, self._stream))

    def _write(self, text: str) -> int:
        try:
            return self._stream.write(text)
        except OSError as error:
            self._fail(error)
            return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> None:
        _abandon(2, self._stream)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


class _Output(_Messages):
    """Stdout, with control characters as escapes: texts of files and names of files cannot steer a terminal."""

    def write(self, text: str) -> int:
        return super().write(_escaped(text))

    def write_exact(self, text: str) -> int:
        return self._write(_escaped(text))

    def _fail(self, error: OSError) -> None:
        raise _OutputError(error) from None


def _abandon(number: int, stream: TextIO) -> None:
    """Connect a stream that fails to the null device, so that the interpreter's own flush at its end succeeds."""
    with contextlib.suppress(OSError, ValueError):
        if stream.fileno() == number:
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)
            stream.flush()


def _escaped(text: str) -> str:
    from atari.base.json_text import escaped

    return escaped(text)
