"""Learning from the environments: evaluation by published protocols, and comparison with published results.

Nothing of it is imported by `import atari`. Evaluation needs NumPy alone; trained policies need what they were made
with (extra `learn`: PyTorch).
"""

from atari.learning.evaluation.compare import Comparison, compare
from atari.learning.evaluation.evaluate import evaluate
from atari.learning.evaluation.protocols import GAME_SETS, PROTOCOLS, EvaluationProtocol
from atari.learning.evaluation.published import Curve, Published, human_scores, published, published_names
from atari.learning.evaluation.results import GameResult, Result
from atari.learning.policies import Policy, ScoresPolicy, load_policy

__all__ = [
    "GAME_SETS",
    "PROTOCOLS",
    "Comparison",
    "Curve",
    "EvaluationProtocol",
    "GameResult",
    "Policy",
    "Published",
    "Result",
    "ScoresPolicy",
    "compare",
    "evaluate",
    "human_scores",
    "load_policy",
    "published",
    "published_names",
]
