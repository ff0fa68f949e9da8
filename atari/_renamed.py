"""Public names of 0.2 that have others now: each raises an error that says the new one."""

from collections.abc import Callable, Mapping
from typing import Any, NoReturn

RENAMED: Mapping[str, str] = {
    "atari.Protocol": "atari.Task",
    "atari.protocols.Protocol": "atari.Task",
    "atari.multiplayer.PreprocessedEnv": "atari.multiplayer.MultiplayerEnv(game, preset='multiplayer_dqn')",
    "atari.lab.CausalMap": "atari.lab.causal.map.CausalMap",
    "atari.lab.GameObject": "atari.lab.objects.GameObject",
    "atari.lab.WatchVector": "atari.lab.Watch",
    "atari.lab.causal.ByteCauses": "atari.lab.causal.map.ByteCauses",
    "atari.lab.causal.CausalMap": "atari.lab.causal.map.CausalMap",
    "atari.lab.causal.Suggestion": "atari.lab.causal.suggestion.Suggestion",
    "atari.lab.causal.causes": "atari.lab.causes",
    "atari.lab.causal.shipped_causes": "atari.lab.shipped_causes",
    "atari.lab.interventions.CheckResult": "atari.lab.interventions.check.CheckResult",
    "atari.lab.interventions.Intervention": "atari.games.interventions.Intervention",
    "atari.lab.interventions.load_file": "atari.lab.interventions.load(game, file)",
    "atari.lab.probes.Episode": "atari.lab.probes.data.Episode",
    "atari.lab.probes.ProbeData": "atari.lab.probes.data.ProbeData",
    "atari.lab.probes.ProbeResult": "atari.lab.probes.probe.ProbeResult",
    "atari.lab.probes.Split": "atari.lab.probes.data.Split",
    "atari.integrations.jax.XlaFunctions": "the named tuple that `xla` returns",
    "atari.integrations.ray.Rollout": "atari.integrations.ray.rollout.Rollout",
    "atari.multiplayer.video.record_game": "atari.recording.RecordReplay, whose replay `Replay.render` films",
    "atari.play.MultiplayerSession": "atari.play.Session(game, players=n)",
    "atari.recording.Divergence": "the `divergence` of what `Replay.verify` returns",
    "atari.recording.Episode": "an item of `Replay.episodes`",
    "atari.recording.FORMATS": "atari.recording.video.formats.FORMATS",
    "atari.recording.Format": "atari.recording.video.formats.Format",
    "atari.recording.Frame": "an item of `Replay.frames`",
    "atari.recording.RecordMatch": "atari.recording.RecordReplay(core, path)",
    "atari.recording.RecordVectorReplay": "atari.recording.RecordReplay(envs, path, index)",
    "atari.recording.RecordVectorVideo": "atari.recording.RecordVideo(envs, video_folder)",
    "atari.recording.Verification": "the class of what `Replay.verify` returns",
    "atari.recording.frame_rate": "the rate of VideoWriter(path, game), its attribute `fps`",
    "atari.roms.Check": "atari.roms.search.Check, which `verify` returns",
    "atari.roms.Identification": "atari.roms.identification.Identification, which `identify` returns",
    "atari.roms.ImportReport": "atari.roms.importing.ImportReport, which `import_from` returns",
    "atari.roms.folders": "atari.roms.locations.folders",
    "atari.roms.path": "atari.roms.locations.path",
    "atari.wrappers.preset_protocol": "atari.Task.of(game, preset=name)",
    "atari.Preset": "atari.task.presets.Preset",
    "atari.multiplayer.Environment": "atari.games.pettingzoo.Environment",
    "atari.wrappers.PRESETS": "atari.PRESETS",
    "atari.wrappers.LazyStack": "atari.wrappers.frame_stack.LazyStack",
    "atari.learning.Batch": "in atari.learning.memory.batches; `ReplayMemory.sample` returns it",
    "atari.learning.Comparison": "in atari.learning.evaluation.compare; `compare` returns it",
    "atari.learning.Curve": "in atari.learning.evaluation.published; `Published.curve` returns it",
    "atari.learning.GameResult": "in atari.learning.evaluation.results; `Result` has one of each game",
    "atari.learning.Sequences": "in atari.learning.memory.batches; `ReplayMemory.sample_sequences` returns it",
    "atari.learning.human_scores": "atari.learning.Published.human_scores",
    "atari.learning.published": "atari.learning.Published",
    "atari.learning.published_names": "atari.learning.Published.names",
    "AtariVectorEnv.members": "AtariVectorEnv.lanes",
    "AtariEnv.make_sound": "AtariEnv.driver.make_sound",
    "AtariEnv.observers": "AtariEnv.driver.observers",
    "AtariEnv.play_frames": "AtariEnv.driver.play_frames(action, frames=n)",
    "AtariEnv.play_until": "AtariEnv.driver.play_until(action, frames=n)",
}
"""The new name by the old one."""


def missing(module: str, name: str) -> Exception:
    """The error for an attribute that a module does not have.

    An old name gets an ImportError: the message of an AttributeError is lost in `from module import name`.
    """
    new = RENAMED.get(f"{module}.{name}")
    if new is None:
        return AttributeError(f"module {module!r} has no attribute {name!r}")
    return ImportError(f"{module}.{name} is now {new}; docs/from-0.2.md has all names that changed")


def old_names(module: str) -> Callable[[str], NoReturn]:
    """The `__getattr__` of a module without lazy attributes: it raises the error of `missing`."""

    def raise_missing(name: str) -> NoReturn:
        raise missing(module, name)

    return raise_missing


def missing_attribute(owner: Any, name: str) -> AttributeError:
    """The error for an attribute that an object does not have."""
    kind = type(owner).__name__
    new = RENAMED.get(f"{kind}.{name}")
    if new is None:
        return AttributeError(f"{kind!r} object has no attribute {name!r}")
    return AttributeError(f"{kind}.{name} is now {new}; docs/from-0.2.md has all names that changed")
