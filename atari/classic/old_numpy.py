"""Names that NumPy has removed, for the scripts that `python -m atari.classic` runs.

Most scripts of Gym's time use `np.float` or `np.int` (removed in NumPy 1.24), some `np.Inf` or `np.bool8` (2.0).
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
    """Define the removed names in NumPy, for this process."""
    for name, meaning in _NAMES.items():
        if name not in vars(np):
            setattr(np, name, meaning)
