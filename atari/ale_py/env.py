"""`ale_py.env`: the environment, where programs import it from."""

from typing import TypedDict

import numpy as np
from typing_extensions import NotRequired

from atari.env import AtariEnv as AtariEnv


class AtariEnvStepMetadata(TypedDict):
    """The type of the `info` of an `AtariEnv`; `reset` with a seed adds `seeds`.

    Example:
        >>> import atari.ale_py as ale_py
        >>> sorted(ale_py.AtariEnvStepMetadata.__annotations__)
        ['episode_frame_number', 'frame_number', 'lives', 'seeds']
    """

    lives: int
    episode_frame_number: int
    frame_number: int
    seeds: NotRequired[tuple[np.uint32, np.uint32]]
