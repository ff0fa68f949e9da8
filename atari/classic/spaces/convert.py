"""Spaces of Gymnasium as classic ones."""

from typing import Any

from gymnasium import spaces

from atari.classic.spaces.box import Box
from atari.classic.spaces.dict import Dict
from atari.classic.spaces.discrete import Discrete
from atari.classic.spaces.multi_binary import MultiBinary
from atari.classic.spaces.multi_discrete import MultiDiscrete
from atari.classic.spaces.tuple import Tuple


def from_gymnasium(space: spaces.Space[Any]) -> spaces.Space[Any]:
    """The classic space of the same elements; a space that Gym did not have is returned unchanged."""
    if isinstance(space, spaces.Box):
        return Box(space.low, space.high, dtype=space.dtype)
    if isinstance(space, spaces.Discrete) and space.start == 0:
        return Discrete(int(space.n))
    if isinstance(space, spaces.MultiDiscrete) and not space.start.any():
        return MultiDiscrete(space.nvec)
    if isinstance(space, spaces.MultiBinary):
        return MultiBinary(space.n)
    if isinstance(space, spaces.Tuple):
        return Tuple(from_gymnasium(part) for part in space.spaces)
    if isinstance(space, spaces.Dict):
        return Dict({name: from_gymnasium(part) for name, part in space.spaces.items()})
    return space
