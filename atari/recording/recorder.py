"""`RecordedCore`: a core whose calls are noted in a replay while they are made."""

import hashlib
import operator
import struct
from os import PathLike
from typing import Any

import atari
from atari.cores import Core
from atari.env import AtariEnv
from atari.game import Game
from atari.recording.replay_events import ACTS_PER_CHUNK, Event, Kind, pack
from atari.recording.replay_file import FRAMES_PER_CHECK, FRAMES_PER_CHUNK, Play, Writer, check, episode, mark
from atari.recording.trouble import Troubled
from atari.roms import find
from atari.roms.image import md5, read_image

NOT_THE_GAMES = ("game", "rom", "core", "render_mode")
"""Options of `AtariEnv` that say where a game is played, and not how."""


def rom_md5(game: Game, rom: str | PathLike[str] | None) -> str:
    """The MD5 of the image that is played."""
    return md5(read_image(find(game, rom)))


def header_of(env: AtariEnv, source: str) -> dict[str, Any]:
    """The header of a replay of this environment; `source` names the class that is recorded."""
    options = {name: value for name, value in env._options.items() if name not in NOT_THE_GAMES}
    return {
        "game": env.game.id,
        "rom": rom_md5(env.game, env._options["rom"]),
        "core": env.core.name,
        "source": source,
        "id": env.spec.id if env.spec else None,
        "options": {name: _plain(value) for name, value in options.items()},
        "package": atari.__version__,
    }


class Recorder(Troubled):
    """Collects what is done, and writes it chunk by chunk.

    If a chunk cannot be written, the recording ends, what follows is ignored, and `raise_trouble` says why: the game
    is in the middle of a step then, where no error helps.

    Raises:
        ValueError: the name does not end in ".a26".
        OSError: the file cannot be written.
    """

    def __init__(self, path: str | PathLike[str], header: dict[str, Any], core: Core) -> None:
        self._writer: Writer | None = Writer(path, header)
        self.path = self._writer.path
        self.frames = 0
        """Frames played so far."""
        self.score = 0
        """The sum of rewards since the last reset."""
        self.core = core
        """What is recorded."""
        self._episodes: list[dict[str, Any]] = []
        self._in_episode = False
        self._held: tuple[int, float] = (0, 1.0)
        self._held_for = 0
        self._saved: dict[bytes, tuple[int, int]] = {}  # by digest: number of the snapshot, and the score then
        self._saves = self._loads = 0
        self._start_chunk()

    @property
    def open(self) -> bool:
        """Whether it still records."""
        return self._writer is not None

    def acted(self, action: int, strength: float, reward: int, played: bool) -> None:
        """Note a call of `act`, and whether it has played a frame (it does not after the end of a game)."""
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
            self._marks.append(mark(self.core))
            if self.frames % FRAMES_PER_CHECK == 0:
                self._checks.append(check(self.core, self.score))
        if self._acts == ACTS_PER_CHUNK:
            self.flush()

    def begin_step(self) -> None:
        """Note that what is done from here on is a step of the environment."""
        self._flush_held(ends_step=False)

    def end_step(self) -> None:
        """Note that what has been done was a step of the environment."""
        if self._writer is None:
            return
        if not self._flush_held(ends_step=True):
            self._events.append(Event(Kind.STEP))
        self.flush_if_full()

    def note(self, kind: Kind, numbers: tuple[int, ...] = (), floats: tuple[float, ...] = ()) -> None:
        """Note anything but an action."""
        if self._writer is None:
            return
        self._flush_held(ends_step=False)
        if kind == Kind.SEED and self._events and self._events[-1].kind == Kind.SEED:
            self._events.pop()  # nothing was done with it
        self._events.append(Event(kind, numbers, floats))

    def begin_episode(self) -> None:
        """Note a reset, before it happens."""
        self._end_episode()
        self.note(Kind.RESET)
        self.score = 0
        self._in_episode = True

    def saved(self, data: bytes) -> None:
        """Note that this snapshot was taken."""
        if self._writer is None:
            return
        self._saved[_digest(data)] = self._saves, self.score
        self._saves += 1
        self.note(Kind.SAVE)

    def restored(self, data: bytes) -> None:
        """Note that the game goes on from this snapshot: one that was taken here, or else the file gets it."""
        if self._writer is None:
            return
        known = self._saved.get(_digest(data))
        if known is not None:
            number, self.score = known
            self.note(Kind.RESTORE, (number,))
        else:
            self.flush()
            self._write("snapshot", data)
            self.note(Kind.LOAD, (self._loads,))
            self._loads += 1
            self.score = 0
        self._in_episode = True

    def flush_if_full(self) -> None:
        """Write a chunk if there is enough for one."""
        if len(self._marks) >= FRAMES_PER_CHUNK or len(self._events) >= ACTS_PER_CHUNK:
            self.flush()

    def flush(self) -> None:
        """Write what there is as a chunk."""
        self._flush_held(ends_step=False)
        if self._events:
            play = Play(self._first, bytes(self._marks), tuple(self._checks), pack(self._events))
            self._start_chunk()
            self._write("play", play)

    def close(self) -> None:
        """Write the end, and close the file. Closing again does nothing.

        Raises:
            OSError: the file is not complete, because it could not be written.
        """
        if self._writer is not None:
            self.flush()
            self._end_episode()
            self._write("end", {"episodes": self._episodes, "check": check(self.core, self.score)})
            self._writer = None
        self.raise_trouble()

    def _start_chunk(self) -> None:
        self._first = self.frames
        self._events: list[Event] = []
        self._marks = bytearray()
        self._checks: list[int] = []
        self._acts = 0

    def _flush_held(self, *, ends_step: bool) -> bool:
        if not self._held_for:
            return False
        action, strength = self._held
        floats = () if strength == 1.0 else (strength,)
        self._events.append(Event(Kind.ACT, (action, self._held_for), floats, ends_step))
        self._held_for = 0
        return True

    def _end_episode(self) -> None:
        if self._in_episode:
            self._episodes.append(episode(self.core, self.score))
        self._in_episode = False

    def _write(self, method: str, what: Any) -> None:
        if self._writer is None:
            return
        try:
            getattr(self._writer, method)(what)
        except OSError as error:
            self._writer = None
            self._trouble = error


class RecordedCore:
    """A core that tells a recorder what is done to it. See `Core` for the methods."""

    def __init__(self, core: Core, recorder: Recorder) -> None:
        self.inner: Any = core
        self._recorder = recorder

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def seed(self, seed: int) -> None:
        """Start over with a seed."""
        self.inner.seed(seed)
        self._recorder.note(Kind.SEED, (operator.index(seed),))

    def reset(self) -> None:
        """Start a new game."""
        self._recorder.begin_episode()
        self.inner.reset()

    def act(self, action: int, strength: float = 1.0) -> int:
        """Play a frame."""
        core = self.inner
        before = core.frame_number
        reward: int = core.act(action, strength)
        self._recorder.acted(operator.index(action), _as_float32(strength), reward, core.frame_number != before)
        return reward

    def set_ram(self, index: int, value: int) -> None:
        """Write one byte of RAM."""
        self.inner.set_ram(index, value)
        self._recorder.note(Kind.POKE, (operator.index(index), operator.index(value)))

    def set_mode(self, mode: int) -> None:
        """Set the game's mode; played from the next reset on."""
        self.inner.set_mode(mode)
        self._recorder.note(Kind.MODE, (operator.index(mode),))

    def set_difficulty(self, difficulty: int) -> None:
        """Set the game's difficulty."""
        self.inner.set_difficulty(difficulty)
        self._recorder.note(Kind.DIFFICULTY, (operator.index(difficulty),))

    def with_sound(self) -> "RecordedCore":
        """This core, with sound from here on."""
        self.inner = self._recorder.core = self.inner.with_sound()
        return self

    def snapshot(self) -> bytes:
        """The whole state."""
        data: bytes = self.inner.snapshot()
        self._recorder.saved(data)
        return data

    def restore(self, data: bytes) -> None:
        """Continue from a snapshot."""
        self.inner.restore(data)
        self._recorder.restored(data)

    def restore_state(self, state: Any) -> None:
        """Continue from a cloned state. What this core makes of it goes into the file.

        Raises:
            RuntimeError: the core cannot say what it has made of it (ale-py).
        """
        if self.inner.name == "ale":
            raise RuntimeError(
                "restore_state() of core 'ale' cannot be recorded, because its states leave out part of the machine; "
                "use snapshot() and restore(), or core='native'"
            )
        self.inner.restore_state(state)
        self._recorder.restored(self.inner.snapshot())


def _as_float32(strength: float) -> float:
    return 1.0 if strength == 1.0 else float(struct.unpack("<f", struct.pack("<f", strength))[0])


def _digest(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=16).digest()


def _plain(value: Any) -> Any:
    """An option as JSON has it."""
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return value.item() if hasattr(value, "item") else value
