"""The format of snapshots. Their content is tested with cores (`atari.testing.check_core`) and environments."""

import struct
from typing import Any

import pytest

from atari.cores import snapshot

FACTS: dict[str, Any] = {"game": "pong", "seed": 2**32 - 1, "mode": None, "probability": 0.25, "state": 2**128 - 1}
BLOBS = {"first": b"abc", "empty": b"", "second": bytes(range(256))}


def test_what_is_packed_is_unpacked() -> None:
    assert snapshot.unpack(snapshot.pack(FACTS, BLOBS)) == (FACTS, BLOBS)


def test_the_layout_is_the_documented_one() -> None:
    data = snapshot.pack({"a": 1}, {"b": b"xyz"})
    assert data[:8] == b"ATARISNP"
    assert struct.unpack_from("<H", data, 8) == (1,)
    (size,) = struct.unpack_from("<I", data, 26)
    assert data[30 : 30 + size] == b'{"a": 1, "blobs": [["b", 3]]}'
    assert data[30 + size :] == b"xyz"


def test_any_flipped_bit_is_noticed() -> None:
    good = snapshot.pack(FACTS, BLOBS)
    for place in range(8 * len(good)):
        bad = bytearray(good)
        bad[place // 8] ^= 1 << place % 8
        with pytest.raises(ValueError, match="snapshot"):
            snapshot.unpack(bytes(bad))


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "the snapshot is empty; pass the bytes that snapshot() returned"),
        (b"PNG....", "these bytes are not a snapshot of atari-envs; pass what snapshot() returned"),
        (b"ATARISNP", "the snapshot is truncated: 8 bytes are less than its header"),
        (b"ATARISNP\x01\x00" + bytes(19), "the snapshot is truncated: 29 bytes are less than its header"),
        (
            b"ATARISNP\x02\x00" + bytes(20),
            "the snapshot has format version 2, this release of atari-envs reads version 1",
        ),
        (b"ATARISNP\x01\x00" + bytes(20), "the snapshot is damaged or truncated: its checksum does not match"),
    ],
)
def test_what_is_no_snapshot_is_refused(data: bytes, text: str) -> None:
    with pytest.raises(ValueError, match="snapshot") as error:
        snapshot.unpack(data)
    assert text in str(error.value)


@pytest.mark.parametrize("data", ["text", bytearray(b"ATARISNP"), None])
def test_what_is_not_bytes_is_refused(data: Any) -> None:
    with pytest.raises(TypeError, match=r"a snapshot is bytes as snapshot\(\) returned them, got "):
        snapshot.unpack(data)


def test_require_names_the_first_difference() -> None:
    snapshot.require({"game": "pong", "mode": None, "more": 1}, {"game": "pong", "mode": None})
    with pytest.raises(
        ValueError, match="taken with mode = 4, but this environment has None; restore it into one made"
    ):
        snapshot.require({"game": "pong", "mode": 4}, {"game": "pong", "mode": None})
    with pytest.raises(ValueError, match="taken with game = None, but this environment has 'pong'"):
        snapshot.require({}, {"game": "pong"})
