"""The format of snapshots: named blobs and facts, with version and checksum, as one `bytes`.

    snapshot of     facts                                            blobs
    AtariEnv        phase of the episode, the generator np_random,   the core's snapshot
                    score, steps and first frame of the game, task
    wrappers        the task, the wrappers that have a state, with   the snapshot of the AtariEnv, the wrappers' arrays
                    their arguments (`atari.env.restorable`)
    MultiplayerEnv  the task, the agents that play                   the core's snapshot, the state of the episode
    NativeCore      core, game, ROM, options, version of the state   the state: machine, RAM of the cartridge, episode,
                                                                     framebuffer, sound, held action, generators
    AleCore         the same, and the seed                           ale-py's state after the last reset, the calls
                                                                     since, a digest of the result

The native core's state is `EnvironmentState` in `emulator/ale/environment_state.hpp` and the bytes of `Console::save`.

Layout, all integers little-endian:

    offset  size  content
    0       8     magic, b"ATARISNP"
    8       2     format version
    10      16    BLAKE2b digest of everything after it
    26      4     length n of the facts
    30      n     the facts, JSON in UTF-8; "blobs" lists the names and sizes of the blobs
    30+n    ...   the blobs, one after the other
"""

import hashlib
import json
import struct
from collections.abc import Mapping
from typing import Any

from atari.base import json_text
from atari.base.magic import SNAPSHOT
from atari.cores import writes

VERSION = 1
_DIGEST_SIZE = 16
_MOST_FACTS = 16 << 20
_HEAD = len(SNAPSHOT) + 2 + _DIGEST_SIZE


def pack(facts: Mapping[str, Any], blobs: Mapping[str, bytes]) -> bytes:
    """Put facts (anything JSON can hold) and blobs into one checked `bytes`."""
    text = json.dumps({**facts, "blobs": [[name, len(blob)] for name, blob in blobs.items()]}).encode()
    body = struct.pack("<I", len(text)) + text + b"".join(blobs.values())
    return SNAPSHOT + struct.pack("<H", VERSION) + _digest(body) + body


def unpack(data: bytes) -> tuple[dict[str, Any], dict[str, bytes]]:
    """The facts and blobs of a snapshot, after checking that it is complete.

    The checksum finds damage. It is no signature: the facts can have any value, and a blob any content.

    Raises:
        TypeError: `data` is not bytes.
        ValueError: `data` is empty, not a snapshot, of another version, truncated or damaged.
    """
    if not isinstance(data, bytes):
        raise TypeError(f"a snapshot is bytes as snapshot() returned them, got {type(data).__name__}")
    if not data:
        raise ValueError("the snapshot is empty; pass the bytes that snapshot() returned")
    if not data.startswith(SNAPSHOT):
        raise ValueError("these bytes are not a snapshot of atari-envs; pass what snapshot() returned")
    if len(data) < _HEAD + 4:
        raise ValueError(f"the snapshot is truncated: {len(data)} bytes are less than its header")
    (version,) = struct.unpack_from("<H", data, len(SNAPSHOT))
    if version != VERSION:
        raise ValueError(
            f"the snapshot has format version {version}, this release of atari-envs reads version {VERSION}"
        )
    body = data[_HEAD:]
    if _digest(body) != data[_HEAD - _DIGEST_SIZE : _HEAD]:
        raise ValueError("the snapshot is damaged or truncated: its checksum does not match its content")
    return _parse(body)


class CopiedBySnapshot:
    """The base of cores that `pickle` and `copy` copy: a new core of the same arguments continues from a snapshot."""

    snapshot: Any
    restore: Any

    def _arguments(self) -> dict[str, Any]:
        """The arguments that make such a core."""
        raise NotImplementedError

    def __getstate__(self) -> dict[str, Any]:
        """Pickling and copying keep the position in the game, and the writes of `Freeze` and `Poke`."""
        slots = writes.definitions(writes.slots(self))
        return {"arguments": self._arguments(), "writes": slots, "snapshot": self.snapshot()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        type(self).__init__(self, **state["arguments"])
        writes.restore(self, state["writes"])
        self.restore(state["snapshot"])


def require(facts: Mapping[str, Any], expected: Mapping[str, Any]) -> None:
    """Check that a snapshot and the environment that restores it have equal facts.

    Raises:
        ValueError: one differs; the message has its name and both values.
    """
    for name, value in expected.items():
        if facts.get(name) != value:
            raise ValueError(
                f"the snapshot was taken with {name} = {_words(facts.get(name))}, but this environment has {value!r}; "
                "restore it into one made with the same options"
            )


def with_options(data: bytes, **options: Any) -> bytes:
    """A core's snapshot with these options of the core that will restore it.

    The state of the native core depends neither on sound, whose generator it always includes, nor on the probability of
    sticky actions or the limit of frames. The snapshot of `AleCore` depends on them, so it is returned unchanged.

    Raises:
        TypeError, ValueError: see `unpack`.
    """
    facts, blobs = unpack(data)
    if facts.get("core") == "ale":
        return data
    return pack({**facts, **options}, blobs)


def require_blobs(blobs: Mapping[str, bytes], *names: str) -> None:
    """Check that a snapshot has blobs of these names.

    Raises:
        ValueError: one is missing.
    """
    for name in names:
        if name not in blobs:
            raise ValueError(f"the snapshot has no {name!r}; pass what snapshot() of this object returned")


def check_generator(state: Any, kind: type[Any]) -> Any:
    """`state`, if it is a state of NumPy's bit generators of this kind.

    Raises:
        ValueError: it is not.
    """
    generator = kind()
    try:
        generator.state = state
        sound = generator.state == state
    except (TypeError, ValueError, KeyError, OverflowError):
        sound = False
    if not sound:
        raise ValueError(f"the snapshot is damaged: np_random is no state of {kind.__name__}")
    return state


def _parse(body: bytes) -> tuple[dict[str, Any], dict[str, bytes]]:
    """The facts and blobs in the bytes after the checksum."""
    start = 4 + struct.unpack_from("<I", body)[0]
    try:
        facts = json_text.parse(body[4:start], "the snapshot", most_bytes=_MOST_FACTS, most_number=2**128)
        sizes = facts.pop("blobs")
        sound = all(type(name) is str and type(size) is int and size >= 0 for name, size in sizes)
    except (TypeError, KeyError, AttributeError):
        sound = False
    if not sound or start + sum(size for _, size in sizes) != len(body):
        raise ValueError("the snapshot is damaged: its facts are no JSON object with the sizes of its blobs")
    blobs = {}
    for name, size in sizes:
        blobs[name] = body[start : start + size]
        start += size
    return facts, blobs


def _words(fact: Any) -> str:
    """A fact for a message; any value but a scalar is only named, because it can be nested too deeply for `repr`."""
    return repr(fact) if fact is None or isinstance(fact, (bool, int, float, str)) else f"a {type(fact).__name__}"


def _digest(body: bytes) -> bytes:
    return hashlib.blake2b(body, digest_size=_DIGEST_SIZE).digest()
