"""Methods that a core inherits from the extension module refuse arguments in one sentence."""

from typing import Any

import pytest

from atari.cores import NativeCore


@pytest.mark.parametrize(
    ("name", "arguments", "text"),
    [
        ("add_write", (3,), r"^the core's method is add_write\(write: Write, now: bool = \.\.\.\), got \(3\)$"),
        ("load", ("x",), r"^the core's method is load\(state: bytes\), got \('x'\)$"),
        ("clone_state", (1, 2), r"^the core's method is clone_state\(include_rng: bool = \.\.\.\), got \(1, 2\)$"),
        ("close", (1,), r"^the core's method is close\(\), got \(1\)$"),
        ("act_until", (0, 2**40), r"^frames must be at most 1,000,000, got 1099511627776$"),
        ("act_until", (0, "x"), r"^frames must be an integer, got 'x'$"),
    ],
)
def test_refused_arguments(name: str, arguments: tuple[Any, ...], text: str) -> None:
    core = NativeCore("pong")
    core.reset()
    with pytest.raises((TypeError, ValueError), match=text):
        getattr(core, name)(*arguments)
