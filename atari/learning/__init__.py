"""Learning from the environments: a replay memory, evaluation by protocols, comparison with published results.

Memory and evaluation need NumPy alone; trained policies need the library that they were made with (extra `learn`:
PyTorch).
"""

from typing import TYPE_CHECKING, Any

from atari._renamed import missing
from atari.learning.evaluation.compare import compare
from atari.learning.evaluation.evaluate import evaluate, record_games
from atari.learning.evaluation.protocols import GAME_SETS, PROTOCOLS, EvaluationProtocol
from atari.learning.evaluation.published import Published
from atari.learning.evaluation.results import Result
from atari.learning.memory import ReplayMemory
from atari.learning.policies import load_policy
from atari.policy import Policy, ScoresPolicy

if TYPE_CHECKING:
    from atari.learning.run import RunFolder

__all__ = [
    "GAME_SETS",
    "PROTOCOLS",
    "EvaluationProtocol",
    "Policy",
    "Published",
    "ReplayMemory",
    "Result",
    "RunFolder",
    "ScoresPolicy",
    "compare",
    "evaluate",
    "load_policy",
    "record_games",
]


def __getattr__(name: str) -> Any:
    if name == "RunFolder":  # imports PyTorch
        from atari.learning.run import RunFolder

        return RunFolder
    raise missing(__name__, name)
