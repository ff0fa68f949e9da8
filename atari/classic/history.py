"""The differences between OpenAI Gym's specs and those registered today, and environments that no longer exist."""

import re
from dataclasses import dataclass, field
from typing import Any

from gymnasium.envs.registration import EnvSpec as ModernSpec

_ALE_STEPS = 27_000  # the limit of ale-py 0.7: half an hour of play at 4 frames a step


@dataclass(frozen=True)
class Changes:
    """The fields in which a spec of Gym differs from today's."""

    max_episode_steps: int | None = None
    nondeterministic: bool = False
    kwargs: dict[str, Any] = field(default_factory=dict)


def atari_changes(modern: ModernSpec) -> Changes:
    """Gym before 0.21 counted steps of Atari games, with limits by ID; ale-py now counts frames."""
    if not is_atari(modern):
        return Changes()
    return Changes(
        _atari_steps(modern.id),
        re.fullmatch(r"ElevatorAction-ram.*-v[04]", modern.id) is not None,
        {"max_num_frames_per_episode": None},
    )


def is_atari(modern: ModernSpec) -> bool:
    """Whether a spec is of a game of Gym's."""
    return "base" in modern.kwargs and "rom" not in modern.kwargs


def _atari_steps(env_id: str) -> int:
    name, _, version = env_id.rpartition("-v")
    if version == "5":
        return _ALE_STEPS
    if name.endswith("NoFrameskip"):
        return 300_000 if name.startswith("SpaceInvaders") else 400_000
    if name.endswith("Deterministic") or version == "4":
        return 100_000
    return 10_000


_ROBOTICS = "pip install gymnasium-robotics, and it is there"
_FATES = {
    r"(Fetch|Hand(Manipulate|Reach)|AntMaze|PointMaze|FrankaKitchen|AdroitHand).*": _ROBOTICS,
    r"Roboschool(Ant|HalfCheetah|Hopper|Humanoid|InvertedPendulum|InvertedDoublePendulum|Reacher|Walker2d)-v\d+": (
        r"Roboschool is no longer maintained, the nearest that is are Gymnasium's MuJoCo environments, such as '\1-v5'"
    ),
    r"(Roboschool|Doom|ppaquette/|flashgames\.|internet\.|gtav\.|wob\.|Go\d+x\d+|Hex\d+x\d+).*": (
        "the package that had it is no longer maintained, and no other has it"
    ),
    r"(NChain|Roulette|HotterColder|GuessingGame|KellyCoinflip|CubeCrash|MemorizeDigits|Striker|Thrower|OffSwitch"
    r"|ConvergenceControl|CNNClassifierTraining|OneRound|TwoRound|PredictActions|PredictObs|Semisuper).*": (
        "Gym dropped it, and no maintained package has it"
    ),
}


def fate(env_id: str) -> str | None:
    """The fate of an environment of Gym or of a package of its time, for an error message; None if unknown."""
    for pattern, text in _FATES.items():
        match = re.match(pattern, env_id)
        if match:
            return match.expand(text)
    return None
