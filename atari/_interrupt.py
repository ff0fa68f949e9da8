"""Ctrl-C during a command that writes files."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event


@contextmanager
def ctrl_c_as_event() -> Iterator[Event]:
    """Set an event at the first Ctrl-C, so that play ends between two steps. A second Ctrl-C acts as usual."""
    interrupted = Event()

    def handle(*_: object) -> None:
        interrupted.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, handle)
    try:
        yield interrupted
    finally:
        signal.signal(signal.SIGINT, before)
