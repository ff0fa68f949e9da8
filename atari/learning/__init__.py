"""Learning from the environments: a replay memory, evaluation by protocols, comparison with published results.

Nothing of it is imported by `import atari`. Memory and evaluation need NumPy alone; trained policies need what they
were made with (extra `learn`: PyTorch).
"""

from atari.learning.evaluation.compare import Comparison, compare
from atari.learning.evaluation.evaluate import evaluate, record_games
from atari.learning.evaluation.protocols import GAME_SETS, PROTOCOLS, EvaluationProtocol
from atari.learning.evaluation.published import Curve, Published, human_scores, published, published_names
from atari.learning.evaluation.results import GameResult, Result
from atari.learning.memory import Batch, ReplayMemory, Sequences
from atari.learning.policies import Policy, ScoresPolicy, load_policy

__all__ = [
    "GAME_SETS",
    "PROTOCOLS",
    "Batch",
    "Comparison",
    "Curve",
    "EvaluationProtocol",
    "GameResult",
    "Policy",
    "Published",
    "ReplayMemory",
    "Result",
    "ScoresPolicy",
    "Sequences",
    "compare",
    "evaluate",
    "human_scores",
    "load_policy",
    "published",
    "published_names",
    "record_games",
]
