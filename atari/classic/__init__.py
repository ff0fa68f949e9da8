"""The interface of OpenAI Gym that textbooks and courses use: `import atari.classic as gym`.

`reset` returns the observation alone, `step` four values, `render` needs no mode at construction, `seed` is a method.
`python -m atari.classic script.py` runs a script in which `import gym` means this package.
"""

import gymnasium.error as error

from atari.classic import envs, logger, spaces, utils, wrappers
from atari.classic.core import ActionWrapper, Env, GoalEnv, ObservationWrapper, RewardWrapper, Wrapper
from atari.classic.envs import make, register, spec
from atari.classic.scoreboard import upload
from atari.classic.spaces import Space

__version__ = "0.21.0"
"""The last version of Gym with this interface, for scripts that check it."""

__all__ = [
    "ActionWrapper",
    "Env",
    "GoalEnv",
    "ObservationWrapper",
    "RewardWrapper",
    "Space",
    "Wrapper",
    "envs",
    "error",
    "logger",
    "make",
    "register",
    "spaces",
    "spec",
    "upload",
    "utils",
    "wrappers",
]
