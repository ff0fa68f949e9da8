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
    found = live.facts_of_classes(_CLASSES)
    kept = (fact for fact in found if not fact.name.endswith(".__init__") or "wrappers" in fact.module)
    return live.versions(kept, importlib.metadata.version("gymnasium"))
