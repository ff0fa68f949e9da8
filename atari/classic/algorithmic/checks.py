"""The check of the arguments: all are integers. This package imports no other part of `atari`."""

import operator
from typing import Any


def check_integer(name: str, value: Any, low: int, high: int) -> int:
    """`value` as an int within low..high.

    Raises:
        TypeError: it is no integer.
        ValueError: it is out of range.
    """
    try:
        number = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = None
    if number is None:
        raise TypeError(f"{name} must be an integer within {low}..{high}, got {value!r}")
    if not low <= number <= high:
        raise ValueError(f"{name} must be within {low}..{high}, got {number}")
    return number
