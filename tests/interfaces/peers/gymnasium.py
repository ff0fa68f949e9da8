"""Gymnasium's base classes, and those of its wrappers whose place ours take under the same name."""

import importlib.metadata

from interfaces import live
from interfaces.compare import Ours
from interfaces.facts import Versions

_CLASSES = {
    "gymnasium.Env": "atari.AtariEnv",
    "gymnasium.vector.VectorEnv": "atari.AtariVectorEnv",
    "gymnasium.wrappers.RecordVideo": "atari.recording.RecordVideo",
    "gymnasium.wrappers.vector.RecordVideo": "atari.recording.video.record_vector_video.RecordVectorVideo",
    "gymnasium.wrappers.ClipReward": "atari.wrappers.ClipReward",
}
OURS = Ours(_CLASSES)


def facts() -> Versions:
    """The facts of the installed version."""
    found = set()
    for path in _CLASSES:
        found |= {
            fact for fact in live.class_facts(path) if fact.name.rpartition(".")[2] != "__init__" or "wrappers" in path
        }
        found |= set(live.attributes_of_source(path))
    return live.versions(found, importlib.metadata.version("gymnasium"))
