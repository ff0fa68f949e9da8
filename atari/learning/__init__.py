"""Learning from the environments: agents and trainings, a replay memory, evaluation by protocols, comparison with
published results.

Memory and evaluation need NumPy alone. Agents, trainings, run folders and trained policies need PyTorch (extra
`learn`), which is imported when one of their names is used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from atari.learning.environments import TrainingEnvironments
from atari.learning.evaluation.compare import compare
from atari.learning.evaluation.evaluate import evaluate, record_games
from atari.learning.evaluation.protocols import GAME_SETS, PROTOCOLS, EvaluationProtocol
from atari.learning.evaluation.published import Published
from atari.learning.evaluation.results import Result
from atari.learning.memory import ReplayMemory
from atari.learning.options import TrainingOptions
from atari.learning.policies import load_policy
from atari.learning.restarts import RestartOptions
from atari.policy import Policy, ScoresPolicy

if TYPE_CHECKING:
    from atari.learning.agent import Agent, TrainingLoop
    from atari.learning.command import main
    from atari.learning.diagnosis.diagnosis import diagnose
    from atari.learning.networks import Encoder
    from atari.learning.replicas import Replicas
    from atari.learning.run_folder import RunFolder
    from atari.learning.training import Training

__all__ = [
    "GAME_SETS",
    "PROTOCOLS",
    "Agent",
    "Encoder",
    "EvaluationProtocol",
    "Policy",
    "Published",
    "ReplayMemory",
    "Replicas",
    "RestartOptions",
    "Result",
    "RunFolder",
    "ScoresPolicy",
    "Training",
    "TrainingEnvironments",
    "TrainingLoop",
    "TrainingOptions",
    "compare",
    "diagnose",
    "evaluate",
    "load_policy",
    "main",
    "record_games",
]

_LATE = {
    "Agent": "agent",
    "Encoder": "networks",
    "Replicas": "replicas",
    "RunFolder": "run_folder",
    "Training": "training",
    "TrainingLoop": "agent",
    "diagnose": "diagnosis.diagnosis",
    "main": "command",
}
"""The modules of the names that are imported when they are used first: most of them need PyTorch."""


def __getattr__(name: str) -> Any:
    if name in _LATE:
        return getattr(import_module(f"{__name__}.{_LATE[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
