"""`ReplayRecorder` and `RecordedCore`: the calls of a core as the events of a replay file."""

import hashlib
import operator
from collections.abc import Sequence
from os import PathLike
from typing import Any

import numpy as np

from atari.base.version import VERSION
from atari.env import AtariEnv
from atari.games.game import Game
from atari.recording.recordable import DeferredErrorMixin
from atari.recording.replay.events import ACTS_PER_CHUNK, Event, Kind, pack
from atari.recording.replay.file_format import (
    FRAMES_PER_CHUNK,
    FRAMES_PER_FULL_HASH,
    PlayChunk,
    ReplayFileWriter,
    Scores,
    episode_summary,
    full_hash,
    no_score,
    short_hash,
)
from atari.roms import find
from atari.roms.image import md5, read_image
from atari.task.json_form import to_short_json


def rom_md5(game: Game, rom: str | PathLike[str] | None) -> str:
    """Return the MD5 of the ROM image that is played."""
    return md5(read_image(find(game, rom)))


def header_of(env: AtariEnv, source: str) -> dict[str, Any]:
    """Return the header of a replay of this environment; `source` is the name of the recorded class.

    Raises:
        ValueError: `env.ale` has set a value that a task has no field for, and that a replay cannot play.
    """
    for name, played in (("frame_skip", 1), ("color_averaging", False)):
        if (value := env.driver.core_options[name]) != played:
            raise ValueError(f"a replay needs {name}={played}, and env.ale has set {value}; set it back, and reset")
    options = env.ale_options()
    if options["interventions"] is None:
        del options["interventions"]  # a header has the key only with interventions
    return {
        "game": env.game.id,
        "rom": rom_md5(env.game, env.driver.rom),
        "core": env.core.name,
        "source": source,
        "id": env.spec.id if env.spec else None,
        "task": to_short_json(env.task),
        "options": json_value(options),
        "package": VERSION,
    }


class ReplayRecorder(DeferredErrorMixin):
    """The events and hashes of a recording, written chunk by chunk. It owns the file.

    With several players an action is a number with a digit in base 18 for each player.

    If a chunk cannot be written, the recording ends and later events are ignored. The error is deferred
    (`DeferredErrorMixin`), because the environment is in the middle of a step.

    Raises:
        ValueError: the name does not end in ".a26r".
        OSError: the file cannot be written.
    """

    def __init__(self, path: str | PathLike[str], header: dict[str, Any], core: Any) -> None:
        self._writer: ReplayFileWriter | None = ReplayFileWriter(path, header)
        self.path = self._writer.path
        self.frames = 0
        """Frames played so far."""
        self.core = core
        """The recorded core."""
        self.score: Any = no_score(self.core)
        """The sum of rewards since the last reset."""
        self._episodes: list[dict[str, Any]] = []
        self._in_episode = False
        self._held: tuple[int, float] = (0, 1.0)  # the action and the strength
        self._held_for = 0
        self._saved: dict[bytes, tuple[int, int]] = {}  # by digest: number of the snapshot, and the score then
        self._saves = self._loads = 0
        self._writes: dict[str, int] = {}  # by definition: its number
        self._start_chunk()

    @property
    def open(self) -> bool:
        """Whether the recording goes on: it was not closed, and no error has ended it."""
        return self._writer is not None

    def record_act(self, action: int, strength: float, reward: Any, played: bool) -> None:
        """Record a call of `act`; `played` is False if it played no frame, as after the end of a game."""
        if self._writer is None:
            return
        if self._held != (action, strength) or not self._held_for:
            self._flush_held(ends_step=False)
            self._held = (action, strength)
        self._held_for += 1
        self._acts += 1
        if played:
            self.frames += 1
            self.score += reward
            self._short_hashes.append(short_hash(self.core))
            if self.frames % FRAMES_PER_FULL_HASH == 0:
                self._full_hashes.append(full_hash(self.core, self.score))
        if self._acts == ACTS_PER_CHUNK:
            self.flush()

    def begin_step(self) -> None:
        """Mark the beginning of a step of the environment."""
        self._flush_held(ends_step=False)

    def end_step(self) -> None:
        """Mark the end of a step of the environment."""
        if self._writer is None:
            return
        if not self._flush_held(ends_step=True):
            self._events.append(Event(Kind.STEP))
        self.flush_if_full()

    def record(self, kind: Kind, numbers: tuple[int, ...] = (), floats: tuple[float, ...] = ()) -> None:
        """Record an event other than an action."""
        if self._writer is None:
            return
        self._flush_held(ends_step=False)
        if kind == Kind.SEED and self._events and self._events[-1].kind == Kind.SEED:
            self._events.pop()  # two seeds in a row: the first has no effect
        self._events.append(Event(kind, numbers, floats))

    def begin_episode(self) -> None:
        """Record a reset. Call it before the core resets, because it stores the last episode's summary."""
        self.end_episode()
        self.record(Kind.RESET)
        self.score = no_score(self.core)
        self._in_episode = True

    def record_snapshot(self, data: bytes) -> None:
        """Record that this snapshot was taken."""
        if self._writer is None:
            return
        self._saved[_digest(data)] = self._saves, self.score
        self._saves += 1
        self.record(Kind.SAVE)

    def record_restore(self, data: bytes) -> None:
        """Record that the core was restored. A snapshot not taken during this recording is stored in the file."""
        if self._writer is None:
            return
        known = self._saved.get(_digest(data))
        if known is not None:
            number, self.score = known
            self.record(Kind.RESTORE, (number,))
        else:
            self.flush()
            self._write("snapshot", data)
            self.record(Kind.LOAD, (self._loads,))
            self._loads += 1
            self.score = no_score(self.core)
        self._in_episode = True

    def record_write(self, definition: str, *, now: bool = False) -> None:
        """Record that a write was added."""
        if definition not in self._writes:
            self._writes[definition] = len(self._writes)
            self._write("write", definition)
        self.record(Kind.ADD_WRITE, (self._writes[definition], int(now)))

    def flush_if_full(self) -> None:
        """Write a chunk if there are enough frames or events for one."""
        if len(self._short_hashes) >= FRAMES_PER_CHUNK or len(self._events) >= ACTS_PER_CHUNK:
            self.flush()

    def flush(self) -> None:
        """Write the collected events as a chunk."""
        self._flush_held(ends_step=False)
        if self._events:
            play = PlayChunk(self._first, bytes(self._short_hashes), tuple(self._full_hashes), pack(self._events))
            self._start_chunk()
            self._write("play", play)

    def close(self) -> None:
        """Write the end chunk and close the file. A second call does nothing.

        Raises:
            OSError: the file could not be written and is not complete.
        """
        if self._writer is not None:
            self.flush()
            self.end_episode()
            self._write("end", {"episodes": self._episodes, "check": full_hash(self.core, self.score)})
            self._writer = None
        self.raise_deferred_error()

    def _start_chunk(self) -> None:
        self._first = self.frames
        self._events: list[Event] = []
        self._short_hashes = bytearray()
        self._full_hashes: list[int] = []
        self._acts = 0

    def _flush_held(self, *, ends_step: bool) -> bool:
        if not self._held_for:
            return False
        action, strength = self._held
        kind = Kind.ACTIONS if isinstance(self.score, Scores) else Kind.ACT
        floats = () if strength == 1.0 else (strength,)
        self._events.append(Event(kind, (action, self._held_for), floats, ends_step))
        self._held_for = 0
        return True

    def end_episode(self) -> None:
        """Keep the summary of the present episode. Call it before the core drops the episode."""
        if self._in_episode:
            self._episodes.append(episode_summary(self.core, self.score))
        self._in_episode = False

    def _write(self, method: str, what: Any) -> None:
        if self._writer is None:
            return
        try:
            getattr(self._writer, method)(what)
        except OSError as error:
            self._writer = None
            self._deferred_error = error


def not_copied() -> TypeError:
    """The error for a copy of a recorder."""
    return TypeError("RecordReplay writes a file and cannot be copied or pickled; close it, or copy what it records")


class RecordedCore:
    """A core whose calls are recorded. See `Core` for the methods."""

    def __init__(self, core: Any, recorder: ReplayRecorder) -> None:
        self.inner: Any = core
        self._recorder = recorder

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def __getstate__(self) -> dict[str, Any]:
        raise not_copied()

    def close(self) -> None:
        """Complete the file, and close the core."""
        try:
            self._recorder.close()
        finally:
            self.inner.close()

    def seed(self, seed: int) -> None:
        """Start over with a seed."""
        self._recorder.end_episode()  # the seed drops the episode
        self.inner.seed(seed)
        self._recorder.record(Kind.SEED, (operator.index(seed),))

    def reset(self) -> None:
        """Start a new game."""
        self._recorder.begin_episode()
        self.inner.reset()

    def act(self, action: int, strength: float = 1.0) -> int:
        """Play a frame."""
        core = self.inner
        before = core.frame_number
        reward: int = core.act(action, strength)
        stored = float(np.float32(strength))  # equal strengths in the file become one event
        self._recorder.record_act(operator.index(action), stored, reward, core.frame_number != before)
        return reward

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM."""
        self.inner.set_ram(index, value)
        self._recorder.record(Kind.POKE, (operator.index(index), operator.index(value)))

    def add_write(self, write: Any, now: bool = False) -> None:
        """Apply a write at each frame from now on."""
        self.inner.add_write(write, now)
        self._recorder.record_write(write.definition, now=now)

    def remove_write(self, write: Any) -> int:
        """End a write; return the slot that it had, or -1."""
        slot: int = self.inner.remove_write(write)
        if slot >= 0:
            self._recorder.record(Kind.REMOVE_WRITE, (slot,))
        return slot

    @property
    def writes(self) -> list[Any]:
        """The writes by slot, None where one has ended."""
        return self.inner.writes

    @writes.setter
    def writes(self, slots: Sequence[Any]) -> None:
        ended = list(enumerate(self.inner.writes))[own_writes(self.inner) :]
        self.inner.writes = slots
        for slot, write in ended:
            if write is not None:
                self._recorder.record(Kind.REMOVE_WRITE, (slot,))
        self.record_writes()

    def record_writes(self) -> None:
        """Record the writes that do not belong to the core's interventions."""
        first = own_writes(self.inner)
        slots = getattr(self.inner, "writes", [])[first:]
        for write in slots:
            self._recorder.record_write((write or slots[-1]).definition)
        for slot, write in enumerate(slots, first):
            if write is None:
                self._recorder.record(Kind.REMOVE_WRITE, (slot,))

    def set_mode(self, mode: int) -> None:
        """Set the game's mode; played from the next reset on."""
        self.inner.set_mode(mode)
        self._recorder.record(Kind.MODE, (operator.index(mode),))

    def set_difficulty(self, difficulty: int) -> None:
        """Set the game's difficulty."""
        self.inner.set_difficulty(difficulty)
        self._recorder.record(Kind.DIFFICULTY, (operator.index(difficulty),))

    def with_sound(self) -> "RecordedCore":
        """This core, with sound from now on."""
        self.inner = self._recorder.core = self.inner.with_sound()
        return self

    def snapshot(self) -> bytes:
        """The whole state, which the replay can restore."""
        data: bytes = self.inner.snapshot()
        self._recorder.record_snapshot(data)
        return data

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot."""
        self.inner.restore(data)
        self._recorder.record_restore(data)

    def restore_state(self, state: Any) -> None:
        """Continue from a cloned state. The core's snapshot after that is stored in the file.

        Raises:
            RuntimeError: the core is ale-py's, whose cloned states are incomplete.
        """
        if self.inner.name == "ale":
            raise RuntimeError(
                "restore_state() of core 'ale' cannot be recorded, because its states leave out part of the machine; "
                "use snapshot() and restore(), or core='native'"
            )
        self.inner.restore_state(state)
        self._recorder.record_restore(self.inner.snapshot())


def own_writes(core: Any) -> int:
    """The number of slots of the writes of a core's interventions; these slots come first."""
    return sum(len(intervention.writes) for intervention in getattr(core, "interventions", ()))


def _digest(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=16).digest()


def json_value(value: Any) -> Any:
    """Convert an option's value to a type of JSON."""
    if isinstance(value, dict):
        return {name: json_value(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_value(item) for item in value]
    return value.item() if hasattr(value, "item") else value
