"""The environment variables that this package reads. All of them are checked when the package is imported."""

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from atari.base.start import PROGRAM


@dataclass(frozen=True)
class Variable:
    """An environment variable.

    Attributes:
        values: the values that it can have, for people; an empty value is that of a variable that is not set.
        check: a function that raises ValueError for another value.
    """

    values: str
    check: Callable[[str], object]


def _check_register(value: str) -> None:
    if value not in ("", "all", "own"):
        raise ValueError(
            "the environment variable ATARI_REGISTER must be 'all' (replace ale-py's IDs) or 'own' (keep them), "
            f"got {value!r}"
        )


VARIABLES = {
    "ATARI_ROMS": Variable("folders with ROM files, with the system's separator between them", str),
    "ATARI_REGISTER": Variable("all, own", _check_register),
    "ATARI_SIMD": Variable("scalar, simd128, avx2, avx512", lambda _: import_module("atari._emulator").simd_level()),
    "ATARI_JIT": Variable("0, 1", lambda _: import_module("atari._emulator").translator()),
}
"""The variables by name. The emulator reads its own two itself, so that its programs without Python have them, too."""


def value(name: str) -> str:
    """The checked value of a variable; "" if it is not set.

    Raises:
        ValueError: it has a value that the package does not know.
    """
    found = os.environ.get(name, "")
    try:
        VARIABLES[name].check(found)
    except UnicodeDecodeError:  # the emulator's sentence has the bytes of the value
        raise ValueError(f"the environment variable {name} is {found!r}, which is no text") from None
    return found


def check() -> None:
    """Check all variables.

    Raises:
        ValueError: one has a value that the package does not know. A program of the package ends with one sentence.
    """
    try:
        for name in VARIABLES:
            value(name)
    except ValueError as error:
        if not PROGRAM:
            raise
        sys.exit(f"atari: error: {error}")
