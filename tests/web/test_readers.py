"""The readers of the page's core in C++ against Python's, on good, damaged and forged files."""

import hashlib
import json
import random
import zlib
from binascii import crc_hqx
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

import atari
from atari.base import json_text
from atari.cores import NativeCore, snapshot
from atari.cores.native import as_ale_reads
from atari.recording.replay import events, file_format

atari_inspection = pytest.importorskip("atari_inspection")  # scripts/test and scripts/dev build it

TOP = Path(__file__).parent.parent.parent
REPLAYS = sorted([*TOP.glob("docs/games/replays/*.a26r"), *TOP.glob("examples/*.a26r")])


def canonical(value: Any) -> str:
    return json.dumps(value, sort_keys=True)


def by_python(data: bytes, path: Path) -> dict[str, Any]:
    """What `web_replay` returns, by Python's reader."""
    path.write_bytes(data)
    content = file_format.read(path)
    plays = []
    for play in content.plays:
        found = []
        for kind, numbers, floats, ends_step in events.unpack(play.events):
            first, second, *_ = (*numbers, 0, 0)
            found.append((int(kind), first, second, list(floats), ends_step))
        plays.append((play.first, play.short_hashes, list(play.full_hashes), found, play.pack()))
    return {
        "header": content.header,
        "end": content.end,
        "plays": plays,
        "snapshots": list(content.snapshots),
        "writes": list(content.writes),
    }


def compare(data: bytes, path: Path) -> bool:
    """Compare both readers, and return whether they accept the file."""
    try:
        expected = by_python(data, path)
    except ValueError as error:
        with pytest.raises(RuntimeError) as raised:
            atari_inspection.web_replay(data)
        place = str(error).partition(": ")[0]
        if place.startswith("the replay is damaged at offset"):
            assert str(raised.value).startswith(place)
        return False
    seen = atari_inspection.web_replay(data)
    seen["header"], seen["end"] = json.loads(seen["header"]), json.loads(seen["end"] or "null")
    seen["writes"] = [write.decode(errors="replace") for write in seen["writes"]]
    assert seen.pop("header") == expected.pop("header")
    assert seen.pop("end") == expected.pop("end")
    assert repr(seen) == repr(expected)  # `repr`: a strength may be no number
    return True


@pytest.mark.parametrize("path", REPLAYS, ids=lambda path: path.stem)
def test_replays_of_the_repository(path: Path, tmp_path: Path) -> None:
    assert compare(path.read_bytes(), tmp_path / "a.a26r")


def chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """The kinds and payloads of a whole file."""
    at = 8
    while at < len(data):
        kind, size, _ = file_format._HEAD.unpack_from(data, at)
        yield kind, data[at + 11 : at + 11 + size]
        at += 11 + size


def damaged(rng: random.Random, data: bytes) -> bytes:
    """Up to three bytes replaced, removed or inserted."""
    changed = bytearray(data)
    for _ in range(rng.randrange(1, 4)):
        at = rng.randrange(len(changed) + 1)
        changed[at : at + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
    return bytes(changed)


def with_changed_events(rng: random.Random, payload: bytes, packed_too: bool) -> bytes:
    """A chunk of play whose events are changed before they are packed, and `packed_too` after it."""
    play = file_format.PlayChunk.unpack(payload, 0, int.from_bytes(payload[:4], "little"))
    packer = zlib.compressobj(rng.randrange(10), zlib.DEFLATED, -15, strategy=rng.choice([0, 2, 3, 4]))
    packed = packer.compress(damaged(rng, zlib.decompress(play.events, -15))) + packer.flush()
    return play._replace(events=damaged(rng, packed) if packed_too else packed).pack()


def forged(rng: random.Random, data: bytes) -> bytes:
    """A file whose chunks are changed, moved, doubled or removed, with right checksums."""
    parts = list(chunks(data))
    for _ in range(rng.randrange(1, 3)):
        at = rng.randrange(len(parts))
        kind, payload = parts[at]
        change = rng.randrange(6)
        if change == 0:
            parts[at] = kind, damaged(rng, payload)
        elif change == 1:
            parts[at] = rng.choice([b"H", b"P", b"S", b"W", b"E", b"Q"]), payload
        elif change == 2:
            parts.insert(rng.randrange(len(parts) + 1), parts[at])
        elif change == 3 and len(parts) > 1:
            del parts[at]
        elif kind == b"P":
            with suppress(ValueError, zlib.error):  # it may have been changed before
                parts[at] = kind, with_changed_events(rng, payload, change == 5)
    file = data[:8] + b"".join(file_format._chunk(kind, payload) for kind, payload in parts)
    return file[: rng.randrange(len(file))] if rng.random() < 0.1 else file


@pytest.mark.parametrize("seed", range(4))
def test_changed_replays(seed: int, tmp_path: Path) -> None:
    rng = random.Random(seed)
    sources = [path.read_bytes() for path in REPLAYS]
    accepted = sum(
        compare((damaged if i % 4 == 0 else forged)(rng, rng.choice(sources)), tmp_path / "a.a26r") for i in range(400)
    )
    assert 20 < accepted < 380


def test_deflate() -> None:
    rng = random.Random(1)
    texts = [b"", b"a", bytes(70_000), rng.randbytes(3000), b"abcabcabc" * 400, *(p.read_bytes() for p in REPLAYS[:9])]
    core = NativeCore("pong", seed=0)
    texts.append(core.save())
    for text in texts:
        for is_zlib, bits in ((True, 15), (False, -15)):
            packed = atari_inspection.web_deflate(text, zlib=is_zlib)
            assert zlib.decompress(packed, bits) == text
            for level in (0, 1, 9):
                packer = zlib.compressobj(level, zlib.DEFLATED, bits)
                stream = packer.compress(text) + packer.flush()
                assert atari_inspection.web_inflate(stream, len(text), zlib=is_zlib) == text
                if text:
                    with pytest.raises(RuntimeError, match="too many"):
                        atari_inspection.web_inflate(stream, len(text) - 1, zlib=is_zlib)
    for text in texts[3:]:
        assert len(atari_inspection.web_deflate(text, zlib=True)) < 1.2 * len(zlib.compress(text, 9)) + 100


def test_damaged_streams() -> None:
    rng = random.Random(2)
    refused = 0
    for _ in range(3000):
        text = bytes(rng.choices(b"abc\0", k=rng.randrange(300)))
        packer = zlib.compressobj(rng.randrange(10), zlib.DEFLATED, -15, strategy=rng.choice([0, 2, 3, 4]))
        stream = damaged(rng, packer.compress(text) + packer.flush())
        unpacker = zlib.decompressobj(-15)
        try:
            expected = unpacker.decompress(stream, 1 << 12)
            good = unpacker.eof and not unpacker.unused_data
        except zlib.error:
            good = False
        if good:
            assert atari_inspection.web_inflate(stream, 1 << 12, zlib=False) == expected
        else:
            refused += 1
            with pytest.raises(RuntimeError):
                atari_inspection.web_inflate(stream, 1 << 12, zlib=False)
    assert 500 < refused < 2990


def test_hashes() -> None:
    rng = random.Random(3)
    for size in (0, 1, 55, 56, 63, 64, 65, 127, 128, 129, 255, 256, 257, 5000):
        data = rng.randbytes(size)
        expected = (
            crc_hqx(data, 0),
            zlib.adler32(data),
            hashlib.md5(data).hexdigest(),
            hashlib.blake2b(data, digest_size=16).hexdigest(),
        )
        assert atari_inspection.web_hashes(data) == expected


def test_json() -> None:
    rng = random.Random(4)
    texts = [
        canonical({"b": [1, -2.5e-7, None, True], "a": {"é": 'x"\\\n\u2028😀'}, "c": []}).encode(),
        b'{"a": 1, "a": 2}', b"[" * 33 + b"]" * 33, b"[" * 32 + b"]" * 32, b"NaN", b"1e999", b"18446744073709551616",
        b"18446744073709551615", b"01", b"-", b"1.", b'"\\ud800"', b'"\xff"', b'"a', b"[1,]", b"", b" 1 ", b"tru", b'"\x01"',
        b'"\xed\xa0\x80"', b'{"a":1}x', b"-0", b"1.5E+3", b'"\\u0041"',
    ]  # fmt: skip
    for text in [*texts, *(damaged(rng, texts[0]) for _ in range(1500))]:
        try:
            value = json_text.parse(text, "it")
        except ValueError as error:
            if "control character" not in str(error):  # Python also refuses texts that a terminal cannot show
                with pytest.raises(RuntimeError):
                    atari_inspection.web_json(text)
            continue
        assert json.loads(atari_inspection.web_json(text)) == value


def test_snapshots() -> None:
    core = NativeCore("pong", seed=2)
    core.reset()
    data = core.snapshot()
    facts = canonical(core._facts())
    assert atari_inspection.web_snapshot(data, facts) == core.save()
    made = atari_inspection.web_pack_snapshot(facts, core.save())
    core.act(2)
    core.restore(made)
    assert atari_inspection.web_snapshot(made, facts) == core.save()
    rng = random.Random(5)
    for _ in range(300):
        changed = damaged(rng, data)
        with pytest.raises(RuntimeError):
            atari_inspection.web_snapshot(changed if changed != data else b"", facts)
    for other, message in (
        (NativeCore("pong", seed=2, mode=1).snapshot(), "taken with mode = 1, but this game has null"),
        (NativeCore("breakout", seed=2).snapshot(), 'taken with game = "breakout"'),
        (snapshot.pack(core._facts(), {"other": b"x"}), "do not fit its blobs"),
        (snapshot.pack(core._facts(), {"state": b"x"}), "no zlib stream"),
        (snapshot.pack({"core": "native"}, {}), "= nothing, but this game has"),
        (data[:20], "less than its header"),
    ):
        with pytest.raises(RuntimeError, match=message):
            atari_inspection.web_snapshot(other, facts)


def test_probabilities() -> None:
    rng = random.Random(6)
    for _ in range(20_000):
        probability = rng.choice([rng.random(), rng.random() / 1000, round(rng.random(), 6), rng.random() ** 8])
        assert atari_inspection.web_probability(probability) == as_ale_reads(probability), probability


def test_every_game_is_in_the_tests() -> None:
    assert {path.stem for path in REPLAYS} >= {name for name, game in atari.games.items() if game.single_player}
