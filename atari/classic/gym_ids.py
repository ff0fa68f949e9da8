"""Gym's IDs: the registered ID for an ID in a script, the fate of environments that no longer exist, and differences
between Gym's specs and those registered today.
"""

import difflib
import re
import sys
import warnings
from importlib import import_module, util

import gymnasium
from gymnasium.envs.registration import EnvSpec as ModernSpec

from atari.classic import logger

VERSION = "0.21.0"
"""The last version of Gym with this interface, for scripts that check it."""


def is_atari(modern: ModernSpec) -> bool:
    """Whether a spec is of a game of Gym's."""
    return "base" in modern.kwargs and "rom" not in modern.kwargs


def is_ours(env_id: str) -> bool:
    """Whether this package registers an ID, which Gymnasium alone does not have."""
    return str(gymnasium.registry[env_id].entry_point).startswith("atari.")


def atari_steps(env_id: str) -> int:
    """The limit of steps of a game by its ID, as Gym before 0.21 had it; ale-py now counts frames."""
    name, _, version = env_id.rpartition("-v")
    if version == "5":
        return 27_000  # the limit of ale-py 0.7: half an hour of play at 4 frames a step
    if name.endswith("NoFrameskip"):
        return 300_000 if name.startswith("SpaceInvaders") else 400_000
    if name.endswith("Deterministic") or version == "4":
        return 100_000
    return 10_000


def is_random_game(env_id: str) -> bool:
    """Whether Gym's spec of a game says that its episodes differ despite equal seeds."""
    return re.fullmatch(r"ElevatorAction-ram.*-v[04]", env_id) is not None


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


_MUJOCO_PY = re.compile(r"gymnasium_robotics\.envs\.(mujoco\.|.*:MujocoPy)")
_VERSION = re.compile(r"(.+)-v(\d+)")


def resolve(env_id: str) -> str:
    """The registered ID for an ID: itself, or its newest version with a warning, if that is newer.

    Args:
        env_id: an ID, which may name a module to import first: "my_module:Corridor-v0".

    Raises:
        TypeError: it is not a string.
        gymnasium.error.UnregisteredEnv: there is no such environment; the message suggests an ID, or a package to
            install.
    """
    if not isinstance(env_id, str):
        raise TypeError(f"make() takes an ID such as 'CartPole-v0', got {env_id!r}")
    module, _, name = env_id.rpartition(":")
    if module:
        import_module(module)
    if not is_alive(name):
        load_robotics()
    if is_alive(name):
        return name
    found = newest(name)
    if found is None:
        raise gymnasium.error.UnregisteredEnv(f"there is no environment {name!r}; {_cure(name)}")
    logger.warn_once(f"{name} is no longer there; this is {found}, its newest version")
    return found


def is_alive(env_id: str) -> bool:
    """Whether an ID is registered and does not need a library that is no longer maintained."""
    spec = gymnasium.registry.get(env_id)
    if spec is None or getattr(spec.entry_point, "__name__", "").startswith("_raise_"):
        return False
    is_old = isinstance(spec.entry_point, str) and _MUJOCO_PY.match(spec.entry_point) is not None
    return not is_old or util.find_spec("mujoco_py") is not None


def load_robotics() -> None:
    """Import Gymnasium-Robotics, if installed, which registers its environments."""
    if "gymnasium_robotics" not in sys.modules and util.find_spec("gymnasium_robotics") is not None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its warning says that it replaces dead registrations
            import_module("gymnasium_robotics")


def newest(env_id: str) -> str | None:
    """The newest registered version of an ID that is no longer there; None if there is none."""
    match = _VERSION.fullmatch(env_id)
    if match is None:
        return None
    name, version = match.group(1), int(match.group(2))
    others = [_VERSION.fullmatch(other) for other in gymnasium.registry if is_alive(other)]
    versions = [int(other.group(2)) for other in others if other and other.group(1) == name]
    last = max(versions, default=-1)
    return f"{name}-v{last}" if last > version else None


def _cure(env_id: str) -> str:
    """The advice for an unknown ID, for the error message."""
    gone = fate(env_id)
    if gone is not None:
        return gone
    by_name: dict[str, list[str]] = {}
    for other in filter(is_alive, gymnasium.registry):
        by_name.setdefault(_skeleton(other), []).append(other)
    near = difflib.get_close_matches(_skeleton(env_id), by_name, n=1)
    if not near:
        return "gym.envs.registry.all() lists what there is"
    version = env_id.rpartition("-v")[2]
    best = max(by_name[near[0]], key=lambda other: (other.endswith(f"-v{version}"), "/" not in other, other))
    return f"did you mean {best!r}?"


def _skeleton(env_id: str) -> str:
    """An ID without namespace, version, case and punctuation, to find IDs with similar spelling."""
    return re.sub(r"^.*/|-v\d+$|[^a-z0-9]", "", env_id.lower())
