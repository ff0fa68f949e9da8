"""The format of replay files (suffix `.a26r`): a header, then chunks of play, each with a checksum, then an end.

The file grows chunk by chunk during the game. If the process is killed, the chunks written before are valid. All
integers are little-endian:

    offset  size  content
    0       8     magic, b"ATARIRPL"
    8       ...   chunks, one after another

    chunk:
    0       1     kind
    1       4     size n of the payload, at most 16 MiB
    5       4     CRC-32 of the payload
    9       2     CRC-16 (CCITT) of the nine bytes before
    11      n     payload

    kind  payload
    H     header, JSON in UTF-8: "format" is the version of this format, 1, or 2 in a replay of several players, whose
          header has "players". The first chunk, only once
    S     snapshot of the recording core, to which events refer by number, counted from 0
    W     a write to RAM, JSON, the argument of `atari.cores.writes.write_of`; events refer to it by number, from 0
    P     play: the events (see `events`) and the hashes of the frames they played:
          0   4   frames before this chunk
          4   2   frames of this chunk, f
          6   2   size of the events, e
          8   e   the events
          ...     (f + 3) // 4 bytes with two bits for each frame, the lowest first: the lowest bits of a CRC-32 of
                  the RAM and the end of the game
          ...     for each frame whose number, counted from 1, is a multiple of 60: the full hash, a CRC-32
    E     end, JSON: the episodes, and "check", the full hash of the last frame. It is the last chunk; a file without
          it was cut while it was recorded

A difference changes the two bits of its frame with a probability of 3/4, and the next full hash except by a collision
of CRC-32.
"""

import json
import struct
import zlib
from binascii import crc_hqx
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from atari.base import durable, json_text, magic
from atari.base.validation import check_file

FORMAT, FORMAT_OF_PLAYERS = 1, 2
SUFFIX = ".a26r"
FRAMES_PER_FULL_HASH = 60
FRAMES_PER_CHUNK = 240

_HEAD = struct.Struct("<cII")
_HEAD_CRC = struct.Struct("<H")
_HEAD_SIZE = _HEAD.size + _HEAD_CRC.size
_PLAY = struct.Struct("<IHH")
_MAX_PAYLOAD_SIZE = 1 << 24


def is_replay(path: str | PathLike[str]) -> bool:
    """Whether `path` is a replay: by the name's ending, or by the content of a file with another one."""
    return Path(path).suffix.lower() == SUFFIX or magic.begins_with(path, magic.REPLAY)


class Corrupt(ValueError):
    """A file that is not a replay, or is damaged. The message has the offset of the damage."""


def short_hash(core: Any) -> int:
    """Return two bits of a hash of the RAM and of the end of the game."""
    return zlib.crc32(core.ram().data, core.game_over << 1 | core.truncated) & 3


class Scores(list[int]):
    """The scores of several players. `+=` adds the rewards of a frame, and makes a new object."""

    def __iadd__(self, rewards: Iterable[int]) -> "Scores":  # type: ignore[override, misc]
        return Scores(score + reward for score, reward in zip(self, rewards, strict=True))


def no_score(core: Any) -> int | Scores:
    """Return the score of `core` at the beginning of a game."""
    players = getattr(core, "players", 0)  # a core of one player has no such attribute
    return Scores([0] * players) if players else 0


def full_hash(core: Any, score: int | Scores) -> int:
    """Return a hash of RAM, screen, score, lives, end of game and truncation."""
    lives = core.player_lives if isinstance(score, Scores) else core.lives
    text = f"{score} {lives} {core.game_over} {core.truncated}".encode()
    return zlib.crc32(text, zlib.crc32(core.screen().data, zlib.crc32(core.ram().data)))


def episode_summary(core: Any, score: int | Scores) -> dict[str, Any]:
    """Return the summary of the core's current episode, for the end chunk."""
    end = "game over" if core.game_over else "truncated" if core.truncated else "open"
    summary = {"frames": core.episode_frame_number, "score": score, "end": end}
    return {**summary, "score": score[0], "scores": list(score)} if isinstance(score, Scores) else summary


class PlayChunk(NamedTuple):
    """A chunk of play."""

    first: int
    """Frames before this chunk."""
    short_hashes: bytes
    """`short_hash` of each frame."""
    full_hashes: tuple[int, ...]
    """`full_hash` of each frame whose number, counted from 1, is a multiple of `FRAMES_PER_FULL_HASH`."""
    events: bytes
    offset: int = 0
    """The chunk's offset in the file."""

    def pack(self) -> bytes:
        """Return the payload."""
        head = _PLAY.pack(self.first, len(self.short_hashes), len(self.events))
        padded = self.short_hashes + bytes(-len(self.short_hashes) % 4)
        bits = bytes(a | b << 2 | c << 4 | d << 6 for a, b, c, d in zip(*[iter(padded)] * 4, strict=True))
        return head + self.events + bits + struct.pack(f"<{len(self.full_hashes)}I", *self.full_hashes)

    @classmethod
    def unpack(cls, payload: bytes, offset: int, first: int) -> "PlayChunk":
        """Return the chunk of a payload, whose first frame must be `first`.

        Raises:
            Corrupt: the payload is not a chunk of play that begins with this frame.
        """
        if len(payload) < _PLAY.size:
            raise _corrupt(offset, "a chunk of play is too short")
        said, frames, size = _PLAY.unpack_from(payload)
        count = (first + frames) // FRAMES_PER_FULL_HASH - first // FRAMES_PER_FULL_HASH
        bits_at = _PLAY.size + size
        full_hashes_at = bits_at + (frames + 3) // 4
        if said != first or len(payload) != full_hashes_at + 4 * count:
            raise _corrupt(offset, "a chunk of play does not fit the chunk before, or its own size")
        short_hashes = bytes(bits >> shift & 3 for bits in payload[bits_at:full_hashes_at] for shift in (0, 2, 4, 6))
        full_hashes = struct.unpack_from(f"<{count}I", payload, full_hashes_at)
        return cls(first, short_hashes[:frames], full_hashes, payload[_PLAY.size : bits_at], offset)


@dataclass(frozen=True)
class ReplayContent:
    """The content of a file. `end` is None if the recording was cut."""

    header: dict[str, Any]
    plays: tuple[PlayChunk, ...]
    snapshots: tuple[bytes, ...]
    end: dict[str, Any] | None
    writes: tuple[str, ...] = ()

    @property
    def frames(self) -> int:
        """Frames of all chunks."""
        return self.plays[-1].first + len(self.plays[-1].short_hashes) if self.plays else 0


class ReplayFileWriter:
    """A replay file that is written chunk by chunk.

    Raises:
        ValueError: the name does not end in ".a26r".
        OSError: the file cannot be written.
    """

    def __init__(self, path: str | PathLike[str], header: Mapping[str, Any]) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() != SUFFIX:
            raise ValueError(f"the name of a replay must end in {SUFFIX!r}, got {str(path)!r}")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        beginning = magic.REPLAY + _chunk(b"H", _json({"format": FORMAT, **header}))
        self._file = durable.start_recording(self.path, beginning)

    def play(self, play: PlayChunk) -> None:
        """Append a chunk of play."""
        self._put(_chunk(b"P", play.pack()))

    def snapshot(self, data: bytes) -> None:
        """Append a snapshot.

        Raises:
            ValueError: it is larger than a chunk can be.
        """
        if len(data) > _MAX_PAYLOAD_SIZE:
            raise ValueError(f"a replay holds snapshots of up to {_MAX_PAYLOAD_SIZE:,} bytes, got {len(data):,}")
        self._put(_chunk(b"S", data))

    def write(self, definition: str) -> None:
        """Append a write."""
        self._put(_chunk(b"W", definition.encode()))

    def end(self, facts: Mapping[str, Any]) -> None:
        """Append the end chunk and close the file."""
        try:
            self._put(_chunk(b"E", _json(facts)))
        finally:
            self.close()

    def close(self) -> None:
        """Close the file without an end chunk."""
        self._file.close()

    def _put(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:  # on a nearly full disk the first write can be partial
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self._file.close()
            raise OSError(
                error.errno, f"{error.strerror}; the replay ends before this, the game goes on", str(self.path)
            ) from error


def read(path: str | PathLike[str]) -> ReplayContent:
    """Read a file.

    Raises:
        Corrupt: the file is not a replay, of another version, or damaged; the message has the offset.
        ValueError: it is a device or a pipe.
        OSError: the file cannot be read.
    """
    header: dict[str, Any] | None = None
    plays: list[PlayChunk] = []
    snapshots: list[bytes] = []
    writes: list[str] = []
    end: dict[str, Any] | None = None
    frames = 0
    for offset, kind, payload in _chunks(Path(path)):
        if (kind == b"H") != (header is None):
            raise _corrupt(offset, "the header must be the first chunk, and the only one of its kind")
        if end is not None:
            raise _corrupt(offset, "a chunk comes after the end")
        if kind == b"H":
            header = _object(payload, offset)
            reads = FORMAT_OF_PLAYERS if "players" in header else FORMAT
            if header.get("format") != reads:
                found = header.get("format")
                text = f"the replay has format {found!r:.40}, and this release of atari-envs reads {reads}"
                raise Corrupt(f"{text}; use the release that wrote it")
        elif kind == b"P":
            plays.append(PlayChunk.unpack(payload, offset, frames))
            frames += len(plays[-1].short_hashes)
        elif kind == b"S":
            snapshots.append(payload)
        elif kind == b"W":
            writes.append(payload.decode(errors="replace"))
        elif kind == b"E":
            end = _object(payload, offset)
        else:
            raise _corrupt(offset, f"there is no kind of chunk {kind!r}")
    if header is None:
        raise _corrupt(len(magic.REPLAY), "the file ends within its header, and holds nothing")
    return ReplayContent(header, tuple(plays), tuple(snapshots), end, tuple(writes))


def _chunks(path: Path) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield offset, kind and payload of each complete chunk."""
    check_file(path)
    with path.open("rb") as file:
        if file.read(len(magic.REPLAY)) != magic.REPLAY:
            raise Corrupt(f"{path} is no replay of atari-envs; `atari play` and `atari record -o game.a26r` write them")
        while True:
            offset = file.tell()
            head = file.read(_HEAD_SIZE)
            if len(head) < _HEAD_SIZE:
                return
            kind, size, crc = _HEAD.unpack_from(head)
            if crc_hqx(head[: _HEAD.size], 0) != _HEAD_CRC.unpack_from(head, _HEAD.size)[0] or size > _MAX_PAYLOAD_SIZE:
                raise _corrupt(offset, "the head of a chunk does not match its checksum")
            payload = file.read(size)
            if len(payload) < size:
                return
            if zlib.crc32(payload) != crc:
                raise _corrupt(offset, "a chunk does not match its checksum")
            yield offset, kind, payload


def _chunk(kind: bytes, payload: bytes) -> bytes:
    head = _HEAD.pack(kind, len(payload), zlib.crc32(payload))
    return head + _HEAD_CRC.pack(crc_hqx(head, 0)) + payload


def _json(facts: Mapping[str, Any]) -> bytes:
    return json.dumps(facts, separators=(",", ":")).encode()


def _object(payload: bytes, offset: int) -> dict[str, Any]:
    try:
        value = json_text.parse(payload, "JSON", most_bytes=_MAX_PAYLOAD_SIZE)
    except ValueError as error:
        raise _corrupt(offset, str(error)) from None
    if not isinstance(value, dict):
        raise _corrupt(offset, "the chunk is no JSON object")
    return value


def _corrupt(offset: int, what: str) -> Corrupt:
    return Corrupt(f"the replay is damaged at offset {offset}: {what}")
