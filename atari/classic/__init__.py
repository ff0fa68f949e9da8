"""The interface of OpenAI Gym that textbooks and courses use: `import atari.classic as gym`.

`reset` returns the observation alone, `step` four values, `render` needs no mode at construction, `seed` is a method.
`python -m atari.classic script.py` runs a script in which `import gym` means this package.
"""

from types import ModuleType

from atari.classic import envs, error, gym_modules, logger, spaces, utils, vector, wrappers
from atari.classic.core import ActionWrapper, Env, GoalEnv, ObservationWrapper, RewardWrapper, Wrapper
from atari.classic.envs import make, register, spec
from atari.classic.gym_ids import VERSION
from atari.classic.logger import undo_logger_setup
from atari.classic.scoreboard import benchmark_spec, upload
from atari.classic.spaces import Space
from atari.classic.utils.reraise import reraise

configuration: ModuleType
version: ModuleType
__version__ = VERSION
notice = None
"""The notice of a newer version: there is none."""

gym_modules.load()

__all__ = [
    "ActionWrapper",
    "Env",
    "GoalEnv",
    "ObservationWrapper",
    "RewardWrapper",
    "Space",
    "Wrapper",
    "benchmark_spec",
    "configuration",
    "envs",
    "error",
    "logger",
    "make",
    "notice",
    "register",
    "reraise",
    "spaces",
    "spec",
    "undo_logger_setup",
    "upload",
    "utils",
    "vector",
    "version",
    "wrappers",
]
