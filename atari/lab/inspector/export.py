"""The exports of an inspection: labels and interventions as TOML, the game as a replay, a part of it as a video."""

from pathlib import Path
from typing import Any

from atari.base import durable
from atari.base.extras import import_extra, install_extra
from atari.env import AtariEnv
from atari.lab.inspector.inspection import Change, Inspection
from atari.lab.inspector.timeline import Timeline
from atari.recording import RecordReplay, VideoWriter

NAMES = ("labels.toml", "interventions.toml", "replay.a26r")
"""The exports of `write`."""

MOST_CLIP_FRAMES = 60 * 60
"""The longest clip: a minute."""


def labels_toml(inspection: Inspection) -> str:
    """The names that the user has given, as lines of a game definition's table `[ram]`.

    Raises:
        ValueError: no byte was named.
    """
    if not inspection.names:
        raise ValueError("no byte was named; choose one and give it a name")
    labels = {
        name: {"index": index, "kind": "other", "sources": ["measured"], "evidence": "seen in play"}
        for index, name in sorted(inspection.names.items())
    }
    return f"# Names given in the inspector, for the game {inspection.game.id!r}\n" + _toml({"ram": labels})


def interventions_toml(inspection: Inspection) -> str:
    """The interventions that are switched on, the frozen bytes and the pokes, as a file of interventions.

    Raises:
        ValueError: there are none of these.
    """
    pokes = [change for change in inspection.changes if isinstance(change, Change) and change.kind == "poke"]
    tables: dict[str, Any] = {name: inspection.interventions[name].definition() for name in inspection.active.added}
    if not inspection.frozen and not pokes and not tables:
        raise ValueError("nothing is frozen or switched on, and no byte was poked; there is no intervention to export")
    for table in tables.values():
        del table["name"]  # the file has it as the table's name
    for index, value in sorted(inspection.frozen.items()):
        name = _name(inspection, index)
        tables[f"frozen_{name}"] = {
            "description": f"{name} (byte {index}) is held at {value}.",
            "source": "own",
            "writes": [{"to": index, "value": value, "when": when} for when in ("reset", "frame")],
            "check": {"frames": 600, "actions": "random", "holds": f"ram[{index}] == {value}"},
        }
    for number, change in enumerate(pokes, 1):
        name = _name(inspection, change.index)
        tables[f"poke_{number}_{name}"] = {
            "description": f"{name} (byte {change.index}) becomes {change.new} after {change.game_frame} frames.",
            "source": "own",
            "writes": [{"to": change.index, "value": change.new, "when": change.game_frame or "reset"}],
        }
    return f"# Changes made in the inspector, for the game {inspection.game.id!r}\n" + _toml(tables)


def write_replay(inspection: Inspection, path: Path) -> Path:
    """Write the played frames, up to the present one, with frozen bytes and pokes, as a replay (.a26r).

    Raises:
        ValueError: no frame was played.
        OSError: the file cannot be written.
    """
    timeline = inspection.main
    if timeline.at == timeline.first:
        raise ValueError("no frame was played; there is nothing to export")
    env = _at_first_frame(inspection)
    recording = RecordReplay(env, path)
    try:
        recorded = Timeline(env.core)
        for frame in timeline.frames(timeline.first, timeline.at):
            recording.recorder.begin_step()
            recorded.play(frame)
            recording.recorder.end_step()
    finally:
        recording.close()
    return path


def write_clip(inspection: Inspection, path: Path, start: int, stop: int) -> None:
    """Write the frames after `start`, up to `stop`, as a video with sound.

    Raises:
        ValueError: there are no such frames, or too many.
        OSError: the file cannot be written.
        gymnasium.error.DependencyNotInstalled: PyAV is not installed.
    """
    timeline = inspection.main
    if not timeline.first <= start < stop <= timeline.end:
        raise ValueError(f"a clip is within frames {timeline.first}..{timeline.end}, got {start}..{stop}")
    if stop - start > MOST_CLIP_FRAMES:
        raise ValueError(f"a clip has at most {MOST_CLIP_FRAMES} frames, got {stop - start}; export the replay instead")
    env = _at_first_frame(inspection)
    env.driver.make_sound()
    try:
        again = Timeline(env.core, timeline.first)
        with VideoWriter(path, inspection.game, scale=2, sound=True) as video:
            for frame in timeline.frames(timeline.first, stop):
                again.play(frame)
                if again.at > start:
                    video.write(env.core.screen_rgb(), env.core.audio())
    finally:
        env.close()


def write(inspection: Inspection, name: str, path: Path) -> None:
    """Write one of `NAMES`.

    Raises:
        ValueError: there is nothing to export.
        OSError: the file cannot be written.
    """
    if name == "replay.a26r":
        write_replay(inspection, path)
    else:
        text = labels_toml(inspection) if name == "labels.toml" else interventions_toml(inspection)
        durable.write_file(path, text.encode())


def _toml(tables: dict[str, Any]) -> str:
    return str(import_extra("tomli_w", f"an export as TOML needs tomli-w: {install_extra('lab')}").dumps(tables))


def _at_first_frame(inspection: Inspection) -> AtariEnv:
    env = inspection.copied_env()
    env.restore_state(inspection.main.first_state)
    return env


def _name(inspection: Inspection, index: int) -> str:
    known = inspection.readings.names.get(index, [f"byte_{index}"])[0]
    return inspection.names.get(index, known)
