"""`json_encode_np`: NumPy's numbers and arrays for `json.dump(..., default=json_encode_np)`."""

from typing import Any

import numpy as np


def json_encode_np(obj: Any) -> Any:
    """The Python value of a number or array of NumPy.

    Raises:
        TypeError: it is something else, which JSON cannot hold.

    Example:
        >>> import json, numpy
        >>> from atari.classic.utils.json_utils import json_encode_np
        >>> json.dumps({"steps": numpy.int64(200)}, default=json_encode_np)
        '{"steps": 200}'
    """
    if isinstance(obj, (np.ndarray, np.generic)):
        return obj.tolist()
    if obj is None or isinstance(obj, (str, int, float, list, dict)):
        return obj
    raise TypeError(f"JSON holds no {type(obj).__name__}, got {obj!r}; give numbers, texts, lists or dictionaries")
