"""The file of a replay (suffix `.a26`): a header, then chunks of play, each with a checksum, then an end.

It grows chunk by chunk while a game is played, so a recording that is killed leaves all chunks but the last one it was
about to write. All integers are little-endian:

    offset  size  content
    0       8     magic, b"ATARIRPL"
    8       ...   chunks, one behind the other

    chunk:
    0       1     kind
    1       4     size n of the payload, at most 16 MiB
    5       4     CRC-32 of the payload
    9       2     CRC-16 (CCITT) of the nine bytes before
    11      n     payload

    kind  payload
    H     header, JSON in UTF-8: "format" is the version of all that is described here. The first chunk, only once
    S     snapshot of the recording core, to which events refer by number, counted from 0
    P     play: what was done (see `replay_events`) and what came of it:
          0   4   frames before this chunk
          4   2   frames of this chunk, f
          6   2   size of the events, e
          8   e   the events
          ...     (f + 3) // 4 bytes with two bits for each frame, the lowest first: of a CRC-32 of the RAM and the end
          ...     for each frame whose number, counted from 1, is a multiple of 60: the CRC-32 of all that is seen
    E     end, JSON: the episodes, and the check of the last frame. The last chunk; without it, the recording was cut

A difference shows in the two bits at its very frame with a probability of 3/4, and in the checks for sure.
"""

import json
import struct
import zlib
from binascii import crc_hqx
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from atari.cores import Core

FORMAT = 1
SUFFIX = ".a26"
FRAMES_PER_CHECK = 60
FRAMES_PER_CHUNK = 240

_MAGIC = b"ATARIRPL"
_HEAD = struct.Struct("<cII")
_HEAD_CRC = struct.Struct("<H")
_HEAD_SIZE = _HEAD.size + _HEAD_CRC.size
_PLAY = struct.Struct("<IHH")
_LARGEST = 1 << 24


class Corrupt(ValueError):
    """A file that is no replay, or a damaged one. The text names the offset of the damage."""


def mark(core: Core) -> int:
    """Two bits that depend on all of the RAM, and on whether the game has ended."""
    return zlib.crc32(core.ram().data, core.game_over << 1 | core.truncated) & 3


def check(core: Core, score: int) -> int:
    """A hash of all that is seen: RAM, picture, score, lives, ends."""
    text = f"{score} {core.lives} {core.game_over} {core.truncated}".encode()
    return zlib.crc32(text, zlib.crc32(core.screen().data, zlib.crc32(core.ram().data)))


def episode(core: Core, score: int) -> dict[str, Any]:
    """What is noted of an episode when another one begins, or at the end."""
    end = "game over" if core.game_over else "truncated" if core.truncated else "open"
    return {"frames": core.episode_frame_number, "score": score, "end": end}


class Play(NamedTuple):
    """A chunk of play, as it is written."""

    first: int
    """Frames before this chunk."""
    marks: bytes
    """`mark` of each frame."""
    checks: tuple[int, ...]
    """`check` of each frame whose number, counted from 1, is a multiple of `FRAMES_PER_CHECK`."""
    events: bytes
    offset: int = 0
    """Where in the file it is."""

    def pack(self) -> bytes:
        """The payload."""
        head = _PLAY.pack(self.first, len(self.marks), len(self.events))
        padded = self.marks + bytes(-len(self.marks) % 4)
        bits = bytes(a | b << 2 | c << 4 | d << 6 for a, b, c, d in zip(*[iter(padded)] * 4, strict=True))
        return head + self.events + bits + struct.pack(f"<{len(self.checks)}I", *self.checks)

    @classmethod
    def unpack(cls, payload: bytes, offset: int, first: int) -> "Play":
        """Take a payload apart; `first` is what it should begin with.

        Raises:
            Corrupt: it is none.
        """
        if len(payload) < _PLAY.size:
            raise _corrupt(offset, "a chunk of play is too short")
        said, frames, size = _PLAY.unpack_from(payload)
        count = (first + frames) // FRAMES_PER_CHECK - first // FRAMES_PER_CHECK
        bits_at = _PLAY.size + size
        checks_at = bits_at + (frames + 3) // 4
        if said != first or len(payload) != checks_at + 4 * count:
            raise _corrupt(offset, "a chunk of play does not fit the one before, or its own size")
        marks = bytes(bits >> shift & 3 for bits in payload[bits_at:checks_at] for shift in (0, 2, 4, 6))
        checks = struct.unpack_from(f"<{count}I", payload, checks_at)
        return cls(first, marks[:frames], checks, payload[_PLAY.size : bits_at], offset)


@dataclass(frozen=True)
class Content:
    """What is in a file. `end` is None if the recording was cut, and `size` is that of the part which is whole."""

    header: dict[str, Any]
    plays: tuple[Play, ...]
    snapshots: tuple[bytes, ...]
    end: dict[str, Any] | None
    size: int

    @property
    def frames(self) -> int:
        """Frames of all chunks."""
        return self.plays[-1].first + len(self.plays[-1].marks) if self.plays else 0


class Writer:
    """A file that grows by a chunk at a time.

    Raises:
        ValueError: the name does not end in ".a26".
        OSError: the file cannot be written.
    """

    def __init__(self, path: str | PathLike[str], header: Mapping[str, Any]) -> None:
        self.path = Path(path)
        if self.path.suffix.lower() != SUFFIX:
            raise ValueError(f"the name of a replay must end in {SUFFIX!r}, got {str(path)!r}")
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._file: BinaryIO = self.path.open("wb", buffering=0)
        self._put(_MAGIC + _chunk(b"H", _json({"format": FORMAT, **header})))

    def play(self, play: Play) -> None:
        """Append a chunk of play."""
        self._put(_chunk(b"P", play.pack()))

    def snapshot(self, data: bytes) -> None:
        """Append a snapshot.

        Raises:
            ValueError: it is larger than a chunk can be.
        """
        if len(data) > _LARGEST:
            raise ValueError(f"a replay holds snapshots of up to {_LARGEST:,} bytes, got {len(data):,}")
        self._put(_chunk(b"S", data))

    def end(self, facts: Mapping[str, Any]) -> None:
        """Append the end and close the file."""
        try:
            self._put(_chunk(b"E", _json(facts)))
        finally:
            self.close()

    def close(self) -> None:
        """Close the file, as it is."""
        self._file.close()

    def _put(self, data: bytes) -> None:
        rest = memoryview(data)
        try:
            while rest:  # a disk that is nearly full takes a part, and then complains
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self._file.close()
            raise OSError(
                error.errno, f"{error.strerror}; the replay ends before this, the game goes on", str(self.path)
            ) from error


def read(path: str | PathLike[str]) -> Content:
    """Read a file.

    Raises:
        Corrupt: it is no replay, of another version, or damaged; the text says at which offset.
        OSError: it cannot be read.
    """
    header: dict[str, Any] | None = None
    plays: list[Play] = []
    snapshots: list[bytes] = []
    end: dict[str, Any] | None = None
    frames, size = 0, len(_MAGIC)
    for offset, kind, payload in _chunks(Path(path)):
        if (kind == b"H") != (header is None):
            raise _corrupt(offset, "the header must be the first chunk, and the only one of its kind")
        if end is not None:
            raise _corrupt(offset, "there is something behind the end")
        if kind == b"H":
            header = _object(payload, offset)
            if header.get("format") != FORMAT:
                found = header.get("format")
                raise _corrupt(offset, f"the format is {found!r}, and this release of atari-envs reads {FORMAT}")
        elif kind == b"P":
            plays.append(Play.unpack(payload, offset, frames))
            frames += len(plays[-1].marks)
        elif kind == b"S":
            snapshots.append(payload)
        elif kind == b"E":
            end = _object(payload, offset)
        else:
            raise _corrupt(offset, f"there is no kind of chunk {kind!r}")
        size = offset + _HEAD_SIZE + len(payload)
    if header is None:
        raise _corrupt(size, "the file ends within its header, and holds nothing")
    return Content(header, tuple(plays), tuple(snapshots), end, size)


def _chunks(path: Path) -> Iterator[tuple[int, bytes, bytes]]:
    """Offset, kind and payload of each chunk that is complete."""
    with path.open("rb") as file:
        if file.read(len(_MAGIC)) != _MAGIC:
            raise Corrupt(f"{path} is no replay of atari-envs; those begin with {_MAGIC!r}")
        while True:
            offset = file.tell()
            head = file.read(_HEAD_SIZE)
            if len(head) < _HEAD_SIZE:
                return
            kind, size, crc = _HEAD.unpack_from(head)
            if crc_hqx(head[: _HEAD.size], 0) != _HEAD_CRC.unpack_from(head, _HEAD.size)[0] or size > _LARGEST:
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
        value = json.loads(payload)
    except (ValueError, RecursionError):
        value = None
    if not isinstance(value, dict):
        raise _corrupt(offset, "what should be a JSON object is none")
    return value


def _corrupt(offset: int, what: str) -> Corrupt:
    return Corrupt(f"the replay is damaged at offset {offset}: {what}")
