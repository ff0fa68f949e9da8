"""The algorithmic tasks of OpenAI Gym: learn to copy, reverse and add the content of a tape, one character at a time.

They are also the worked example of an environment of your own. Read in this order: `environment` has the rules and is a
complete `gymnasium.Env`, whose inputs grow with success, and renders as text; `tasks` has the two kinds of input and
the five tasks, a few lines each.

The tasks come from Zaremba et al. 2015, "Learning Simple Algorithms from Examples" (arXiv:1511.07275), with the
rules of OpenAI Gym 0.17.
"""

from atari.classic.algorithmic.environment import AlgorithmicEnv
from atari.classic.algorithmic.tasks import (
    CopyEnv,
    DuplicatedInputEnv,
    GridEnv,
    RepeatCopyEnv,
    ReversedAdditionEnv,
    ReverseEnv,
    TapeEnv,
)

__all__ = [
    "AlgorithmicEnv",
    "CopyEnv",
    "DuplicatedInputEnv",
    "GridEnv",
    "RepeatCopyEnv",
    "ReverseEnv",
    "ReversedAdditionEnv",
    "TapeEnv",
]
