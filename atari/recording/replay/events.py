"""The events of a replay, which are calls of a core, and how they are packed.

The calls of a core determine a game: wrappers, no-op resets and frame skips result in calls, and sticky actions follow
from the core's seed. An action repeated for several frames is one event. The end of a step of the environment is a bit
of its last event. Repeating the calls reproduces the game on every core.

The codes of all events come first and all arguments after them, because this order compresses better:

    code         arguments                 meaning
    0x00..0x11   frames                    an action, the last one of a step
    + 0x20                                 the same, but the step goes on
    + 0x40       frames, strength          the same, with a strength of the paddle (float32)
    0x80         -                         reset: a new game
    0x81         seed                      seed the core
    0x82         index, value              write a byte of RAM
    0x83         -                         a snapshot is taken; they are numbered from 0
    0x84         number                    restore the snapshot of that number
    0x85         number                    restore a snapshot stored in the file, not taken during the recording
    0x86, 0x87   number                    set the game's mode, or difficulty
    0x88         radius, angle, fire       the continuous action (three float32) that the following actions come from
    0x89         -                         the end of a step whose last event is not an action
    0x8A         number, now               add the write of that number; if `now` is 1, apply it at once too
    0x8B         slot                      remove the write in that slot
    0x90         actions, frames           the actions of several players, digits in base 18, the first player's lowest

Whole numbers are in base 128, the lowest digit first, with 128 added to all digits but the last. The number of codes is
such a number and comes first. The whole is compressed with raw DEFLATE.
"""

import struct
import zlib
from collections.abc import Iterable, Iterator
from enum import IntEnum
from io import BytesIO
from typing import NamedTuple

from atari.games.actions import PLAYER_ACTIONS

ACTS_PER_CHUNK = 4096
"""The most frames of actions in one chunk."""

_GOES_ON, _STRENGTH = 0x20, 0x40
_FLOAT, _FLOATS = struct.Struct("<f"), struct.Struct("<3f")
_MAX_EVENTS_SIZE = 1 << 20


class Kind(IntEnum):
    """The kinds of events. The values are codes, except that ACT has many codes."""

    ACT = 0x00
    RESET = 0x80
    SEED = 0x81
    POKE = 0x82
    SAVE = 0x83
    RESTORE = 0x84
    LOAD = 0x85
    MODE = 0x86
    DIFFICULTY = 0x87
    CONTINUOUS_ACTION = 0x88
    STEP = 0x89
    ADD_WRITE = 0x8A
    REMOVE_WRITE = 0x8B
    ACTIONS = 0x90


_NUMBERS = {Kind.RESET: 0, Kind.SAVE: 0, Kind.STEP: 0, Kind.POKE: 2, Kind.ADD_WRITE: 2, Kind.ACTIONS: 2}
"""The number of integer arguments of the kinds that have not one."""


class Event(NamedTuple):
    """One event. ACT has the action and its number of frames in `numbers`, and in `floats` the strength, if not 1."""

    kind: Kind
    numbers: tuple[int, ...] = ()
    floats: tuple[float, ...] = ()
    ends_step: bool = False


def pack(events: Iterable[Event]) -> bytes:
    """Return events as bytes."""
    codes, arguments = bytearray(), bytearray()
    for kind, numbers, floats, ends_step in events:
        if kind == Kind.ACT:
            action, frames = numbers
            codes.append(action | (0 if ends_step else _GOES_ON) | (_STRENGTH if floats else 0))
            _put(arguments, frames)
            arguments += _FLOAT.pack(*floats) if floats else b""
        else:
            codes.append(kind)
            for number in numbers:
                _put(arguments, number)
            arguments += _FLOATS.pack(*floats) if floats else b""
    count = bytearray()
    _put(count, len(codes))
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    return packer.compress(count + codes + arguments) + packer.flush()


def unpack(data: bytes) -> list[Event]:
    """Return the events that `pack` has packed.

    Raises:
        ValueError: `data` is not the result of `pack`.
    """
    try:
        return list(_events(BytesIO(_inflate(data))))
    except (IndexError, struct.error, zlib.error, KeyError) as error:
        raise ValueError(f"the events cannot be unpacked ({error})") from None


def _events(text: BytesIO) -> Iterator[Event]:
    count = _number(text)
    codes = text.read(count)
    acts = 0
    for code in codes:
        if code < 0x80:
            action = code & 0x1F
            frames = _number(text)
            acts += frames
            if action >= len(PLAYER_ACTIONS) or acts > ACTS_PER_CHUNK:
                raise ValueError(f"there is an action {action}, or there are more than {ACTS_PER_CHUNK} actions")
            strength = _FLOAT.unpack(text.read(_FLOAT.size)) if code & _STRENGTH else ()
            yield Event(Kind.ACT, (action, frames), strength, not code & _GOES_ON)
        elif code == Kind.CONTINUOUS_ACTION:
            yield Event(Kind.CONTINUOUS_ACTION, (), _FLOATS.unpack(text.read(_FLOATS.size)))
        else:
            kind = Kind(code)
            numbers = tuple(_number(text) for _ in range(_NUMBERS.get(kind, 1)))
            acts += numbers[1] if kind == Kind.ACTIONS else 0
            if acts > ACTS_PER_CHUNK:
                raise ValueError(f"there are more than {ACTS_PER_CHUNK} actions")
            yield Event(kind, numbers)
    if len(codes) < count or text.read(1):
        raise ValueError("the events end before their arguments")


def _number(text: BytesIO) -> int:
    value = shift = 0
    while True:
        digit = text.read(1)[0]
        value |= (digit & 0x7F) << shift
        if digit < 0x80:
            return value
        shift += 7
        if shift > 28:
            raise ValueError("a number is larger than 32 bits")


def _put(out: bytearray, number: int) -> None:
    while number >= 0x80:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    out.append(number)


def _inflate(data: bytes) -> bytes:
    unpacker = zlib.decompressobj(-15)
    text = unpacker.decompress(data, _MAX_EVENTS_SIZE)
    if not unpacker.eof or unpacker.unused_data:
        raise ValueError("the events are too many, or cut")
    return text
