"""What OpenAI Gym's environments were, where that differs from what is registered today."""

import re
from dataclasses import dataclass, field
from typing import Any

from gymnasium.envs.registration import EnvSpec as ModernSpec

from atari import registration

_ALE_STEPS = 27_000  # of ale-py 0.7, half an hour of play, as 108,000 frames are


@dataclass(frozen=True)
class Changes:
    """In what a spec of Gym differs from today's."""

    max_episode_steps: int | None = None
    nondeterministic: bool = False
    kwargs: dict[str, Any] = field(default_factory=dict)


def atari_changes(modern: ModernSpec) -> Changes:
    """Gym before 0.21 counted steps of Atari games, with limits by ID, where ale-py now counts frames."""
    if modern.id not in registration.ids():
        return Changes()
    family, game = registration.resolve(modern.id)
    return Changes(
        _atari_steps(family, game),
        game == "elevator_action" and family.obs_type == "ram" and family.version < 5,
        {"max_num_frames_per_episode": None},
    )


def _atari_steps(family: registration.Family, game: str) -> int:
    if family.version == 5:
        return _ALE_STEPS
    if family.suffix.endswith("NoFrameskip"):
        return 300_000 if game == "space_invaders" else 400_000
    if family.suffix.endswith("Deterministic") or family.version == 4:
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
    """What became of an environment that Gym or a package of its time had; None if there is nothing to tell."""
    for pattern, text in _FATES.items():
        match = re.match(pattern, env_id)
        if match:
            return match.expand(text)
    return None
