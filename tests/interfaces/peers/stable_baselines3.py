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
    found = set()
    for path in _CLASSES:
        found |= {
            fact for fact in live.class_facts(path) if fact.path != "stable_baselines3.common.vec_env.VecEnv.__init__"
        }
        found |= set(live.attributes_of_source(path))
    return live.versions(found, importlib.metadata.version("stable-baselines3"))
