"""Inspections of replays and of saved states."""

from pathlib import Path
from typing import Any

from atari.base.validation import check_file
from atari.cores import snapshot
from atari.env import AtariEnv
from atari.games.catalog import games
from atari.lab.inspector.inspection import Agent, Inspection
from atari.lab.inspector.timeline import MOST_FRAMES, NEW_GAME, FrameInput, Timeline
from atari.recording import Replay
from atari.recording.replay.events import Kind
from atari.task import Task

_MOST_BYTES = 64 << 20


def inspection_of_replay(path: Path, *, rom: Path | None = None, agent: Agent | None = None) -> Inspection:
    """An inspection at the beginning of a replay, with all its frames to play, step and scrub through.

    Raises:
        ValueError, OSError: see `Replay.load`.
    """
    replay = Replay.load(path, rom=rom)
    inspection = Inspection(replay.make_env(frameskip=1, obs_type="rgb", render_mode=None), agent=agent)
    _fill(inspection.main, replay)
    inspection.main.seek(inspection.main.first)
    inspection.let_agent_play(agent is not None)
    if replay.frames_total > MOST_FRAMES:
        inspection.notice = f"the replay has {replay.frames_total:,} frames; the first {MOST_FRAMES:,} are shown"
    return inspection


def _fill(timeline: Timeline, replay: Replay) -> None:
    """Append the frames of a replay, which are played on the core of the timeline."""
    core: Any = timeline.core
    writes: dict[int, int] = {}
    state: Any = None
    slots: tuple[Any, ...] | None = None
    for event, calls in replay.walk(core):
        for call in calls:
            if event.kind == Kind.POKE:
                index, value = event.numbers
                writes[index] = value
            elif event.kind in (Kind.ADD_WRITE, Kind.REMOVE_WRITE):
                slots = tuple(core.writes)
                writes, state = {}, core.clone_state(include_rng=True)
            elif event.kind in (Kind.SEED, Kind.RESTORE, Kind.LOAD, Kind.MODE, Kind.DIFFICULTY):
                writes, state = {}, core.clone_state(include_rng=True)
            elif event.kind == Kind.RESET or (event.kind == Kind.ACT and call.played):
                action = NEW_GAME if event.kind == Kind.RESET else event.numbers[0]
                strength = event.floats[0] if event.floats else 1.0
                frame = FrameInput(action, tuple(writes.items()), (), strength, state, slots)
                writes, state = {}, None
                if not timeline.append(frame, call.reward):
                    return


def inspection_of_snapshot(path: Path, *, rom: Path | None = None, agent: Agent | None = None) -> Inspection:
    """An inspection that begins in a saved state: the file of F5 in `atari play`, or a result of `snapshot`.

    Raises:
        ValueError: it is no snapshot, damaged, or of an unknown game, another ROM or version.
        OSError: it cannot be read.
    """
    with check_file(path).open("rb") as stream:
        data = stream.read(_MOST_BYTES)
    try:
        facts, blobs = snapshot.unpack(data)
        text = None  # the task, which snapshots of an AtariEnv have
        for _ in range(3):  # a file of `atari play` contains wrappers', then an AtariEnv's, then a core's
            inner = blobs.get("env") or blobs.get("core")
            if facts.get("of") is None or inner is None:
                break
            data, text = inner, facts.get("task")
            facts, blobs = snapshot.unpack(data)
        if facts.get("core") != "native" or not isinstance(facts.get("game"), str):
            raise ValueError(f"it is of the core {facts.get('core')!r}; the inspector plays on the core 'native'")
        if facts["game"] not in games:
            raise ValueError(f"it is of the game {facts['game']!r}, which is not one of `atari info`")
        names = ("repeat_action_probability", "mode", "difficulty")
        options = {name: facts[name] for name in names if name in facts}
        if text is not None:
            options["interventions"] = Task.from_json(text, games[facts["game"]]).interventions
        limit = facts.get("max_num_frames_per_episode") or None
        env = AtariEnv(facts["game"], frameskip=1, max_num_frames_per_episode=limit, rom=rom, **options)
        env.reset(seed=0)
        env.core.restore(snapshot.with_options(data, sound=False, frame_skip=1, color_averaging=False))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path} cannot be opened as a saved state: {error}") from error
    return Inspection(env, agent=agent)
