"""Whether an observation is in a space, with a message about the part outside of it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from atari.testing.contract import require


def require_in(space: spaces.Space[Any], value: Any, call: str) -> None:
    """Check the type, shape, dtype and bounds of an observation; `space.contains` alone accepts dtypes that fit.

    Raises:
        ContractError: the observation, or a part of it, is not in the space.
    """
    if isinstance(space, spaces.Dict):
        seen = list(value) if isinstance(value, Mapping) else f"{value!r:.60}"
        keys = isinstance(value, Mapping) and value.keys() == space.spaces.keys()
        require(keys, f"{call} must return an observation with the keys {list(space.spaces)}, got {seen}")
        for key, part in space.spaces.items():
            require_in(part, value[key], f"{call}[{key!r}]")
    elif isinstance(space, spaces.Tuple):
        fits = isinstance(value, tuple) and len(value) == len(space.spaces)
        require(fits, f"{call} must return a tuple of {len(space.spaces)} observations, got {value!r:.60}")
        for index, part in enumerate(space.spaces):
            require_in(part, value[index], f"{call}[{index}]")
    else:
        if isinstance(space, spaces.Box):
            seen = f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else f"{value!r:.60}"
            fits = isinstance(value, np.ndarray) and (value.dtype, value.shape) == (space.dtype, space.shape)
            require(fits, f"{call} must return an observation {space.dtype} {space.shape}, got {seen}")
        require(value in space, f"{call} returned an observation that is not in {space}: {value!r:.80}")
