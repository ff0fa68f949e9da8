"""Elements of spaces as flat arrays, by Gymnasium's functions."""

from typing import Any

import gymnasium.spaces.utils as _modern
from gymnasium.spaces import Space
from gymnasium.spaces.utils import FlatType, T, flatdim, flatten, unflatten

from atari.classic.spaces.convert import from_gymnasium

__all__ = ["FlatType", "T", "flatdim", "flatten", "flatten_space", "unflatten"]


def flatten_space(space: Space[Any]) -> Space[Any]:
    """The `Box` of the flat elements of a space.

    Example:
        >>> from atari.classic import spaces
        >>> spaces.flatten_space(spaces.Dict(place=spaces.Discrete(4), speed=spaces.Box(-1, 1, (2,))))
        Box(6,)
    """
    return from_gymnasium(_modern.flatten_space(space))
