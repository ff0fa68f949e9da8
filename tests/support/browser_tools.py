"""Waiting for a page, whatever else the machine does."""

import time
from collections.abc import Callable
from typing import Any

LIMIT = 60
"""Seconds after which what a test waits for counts as never true."""


def wait_until(page: Any, condition: Callable[[], Any]) -> None:
    """Let the page go on until a condition is true."""
    until = time.monotonic() + LIMIT
    while not condition():
        assert time.monotonic() < until, f"it did not come true in {LIMIT} seconds"
        page.wait_for_timeout(20)
