"""The names that NumPy has dropped since, for the scripts that `python -m atari.classic` runs.

Nearly every script of the time says `np.float` or `np.int` somewhere (dropped in NumPy 1.24), and some `np.Inf` or
`np.bool8` (2.0).
"""

import builtins
from typing import Any

import numpy as np

_NAMES: dict[str, Any] = {
    **{name: getattr(builtins, name) for name in ("bool", "complex", "float", "int", "object", "str")},
    "Inf": np.inf,
    "NaN": np.nan,
    "alltrue": np.all,
    "bool8": np.bool_,
    "complex_": np.complex128,
    "cumproduct": np.cumprod,
    "float_": np.float64,
    "infty": np.inf,
    "long": int,
    "product": np.prod,
    "sometrue": np.any,
    "unicode_": np.str_,
}


def restore() -> None:
    """Give NumPy, in this process, those names that it lacks."""
    for name, meaning in _NAMES.items():
        if name not in vars(np):
            setattr(np, name, meaning)
