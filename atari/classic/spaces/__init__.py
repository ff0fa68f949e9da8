"""Gym's spaces, which print as `Discrete(2)` or `Box(4,)`.

They are subclasses of Gymnasium's, with Gym's constructors and texts, so that Gymnasium's wrappers and other libraries
accept them.
"""

from gymnasium.spaces import Sequence, Space, Text

from atari.classic.spaces import dict as dict_space
from atari.classic.spaces import prng, utils
from atari.classic.spaces import tuple as tuple_space
from atari.classic.spaces.box import Box
from atari.classic.spaces.convert import from_gymnasium
from atari.classic.spaces.dict import Dict
from atari.classic.spaces.discrete import Discrete
from atari.classic.spaces.graph import Graph, GraphInstance
from atari.classic.spaces.multi_binary import MultiBinary
from atari.classic.spaces.multi_discrete import MultiDiscrete
from atari.classic.spaces.prng import seed
from atari.classic.spaces.tuple import Tuple
from atari.classic.spaces.utils import flatdim, flatten, flatten_space, unflatten

__all__ = [
    "Box",
    "Dict",
    "Discrete",
    "Graph",
    "GraphInstance",
    "MultiBinary",
    "MultiDiscrete",
    "Sequence",
    "Space",
    "Text",
    "Tuple",
    "dict_space",
    "flatdim",
    "flatten",
    "flatten_space",
    "from_gymnasium",
    "prng",
    "seed",
    "tuple_space",
    "unflatten",
    "utils",
]
