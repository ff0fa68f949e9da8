"""Names and habits that NumPy has removed, for the scripts that `python -m atari.classic` runs.

Most scripts of Gym's time use `np.float` or `np.int` (removed in NumPy 1.24), some `np.Inf`, `np.cast` or `np.bool8`
(2.0). `np.array(x, copy=False)` meant "copy only if necessary"; rows of unequal length became arrays of objects.
"""

import builtins
import functools
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np


class _Cast:
    """`np.cast[np.uint8](x)`: x in another dtype."""

    def __getitem__(self, dtype: Any) -> Callable[[Any], Any]:
        return lambda x: np.asarray(x, dtype)


_NAMES: dict[str, Any] = {
    **{name: getattr(builtins, name) for name in ("bool", "complex", "float", "int", "object", "str")},
    **dict.fromkeys(("Inf", "Infinity", "PINF", "infty"), np.inf),
    "NINF": -np.inf,
    "NZERO": -0.0,
    "NaN": np.nan,
    "PZERO": 0.0,
    "alltrue": np.all,
    "asfarray": lambda a, dtype=np.float64: np.asarray(a, dtype),
    "asscalar": lambda a: a.item(),
    "bool8": np.bool_,
    "cast": _Cast(),
    "cfloat": np.complex128,
    "complex_": np.complex128,
    "cumproduct": np.cumprod,
    "float_": np.float64,
    "in1d": lambda ar1, ar2, **options: np.isin(np.ravel(ar1), ar2, **options),
    "issubclass_": lambda kind, other: isinstance(kind, type) and issubclass(kind, other),
    "long": int,
    "longfloat": np.longdouble,
    "mat": np.asmatrix,
    "msort": lambda a: np.sort(a, axis=0),
    "product": np.prod,
    "round_": np.round,
    "row_stack": np.vstack,
    "sctypes": {
        "int": [np.int8, np.int16, np.int32, np.int64],
        "uint": [np.uint8, np.uint16, np.uint32, np.uint64],
        "float": [np.float16, np.float32, np.float64, np.longdouble],
        "complex": [np.complex64, np.complex128, np.clongdouble],
        "others": [bool, object, bytes, str, np.void],
    },
    "singlecomplex": np.complex64,
    "sometrue": np.any,
    "string_": np.bytes_,
    "trapz": getattr(np, "trapezoid", None),
    "unicode_": np.str_,
}


_IF_NECESSARY = None if np.lib.NumpyVersion(np.__version__) >= "2.0.0" else False
"""The argument `copy` of `np.array` that copies only if necessary."""


def restore() -> None:
    """Define the removed names in NumPy, and let `np.array` do what it did, for this process."""
    for name, meaning in _NAMES.items():
        if name not in vars(np) and meaning is not None:
            setattr(np, name, meaning)
    vars(np)["array"] = _lenient(np.array)
    # The lazy stacks of scripts have an `__array__` without `copy`, which NumPy 2 still calls, with this warning.
    warnings.filterwarnings("ignore", "__array__ implementation doesn't accept a copy keyword", DeprecationWarning)


def _lenient(array: Callable[..., Any]) -> Callable[..., Any]:
    """`np.array`, whose `copy=False` copies if necessary, and which makes arrays of objects of unequal rows."""

    @functools.wraps(array)
    def lenient(values: Any, *arguments: Any, **options: Any) -> Any:
        if options.get("copy") is False:
            options["copy"] = _IF_NECESSARY
        try:
            return array(values, *arguments, **options)
        except ValueError as error:
            if "inhomogeneous" not in str(error) or arguments or "dtype" in options:
                raise
        warnings.warn("np.array of rows of unequal length: the result is an array of objects", stacklevel=2)
        return array(values, dtype=object, **options)

    return lenient
