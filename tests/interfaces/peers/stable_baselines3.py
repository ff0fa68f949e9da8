"""Stable-Baselines3's base class of vectors and its recorder, whose places `atari.sb3` takes."""

import importlib.metadata

from interfaces import live
from interfaces.compare import Ours
from interfaces.facts import Versions

_CLASSES = {
    "stable_baselines3.common.vec_env.VecEnv": "atari.sb3.AtariVecEnv",
    "stable_baselines3.common.vec_env.VecVideoRecorder": "atari.sb3.RecordVideo",
}
OURS = Ours(_CLASSES)


def facts() -> Versions:
    """The facts of the installed version."""
    live.require("stable_baselines3", "stable-baselines3")
    found = live.facts_of_classes(_CLASSES)
    kept = (fact for fact in found if fact.path != "stable_baselines3.common.vec_env.VecEnv.__init__")
    return live.versions(kept, importlib.metadata.version("stable-baselines3"))
