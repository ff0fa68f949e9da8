"""The replay file format: round trips, and errors for cut, damaged and arbitrary bytes."""

import random
import warnings
import zlib
from binascii import crc_hqx
from pathlib import Path

import pytest
from replay_tools import record

from atari.recording import Replay
from atari.recording.replay import file_format
from atari.recording.replay.events import ACTS_PER_CHUNK, Event, Kind, pack, unpack
from atari.recording.replay.file_format import Corrupt, PlayChunk, ReplayFileWriter, read

EVENTS = [
    Event(Kind.SEED, (2**32 - 2,)),
    Event(Kind.RESET),
    Event(Kind.ACT, (17, 300), (), True),
    Event(Kind.ACT, (0, 1), (), False),
    Event(Kind.CONTINUOUS_ACTION, (), (0.5, -3.0, 1.0)),
    Event(Kind.ACT, (3, 127), (0.25,), True),
    Event(Kind.ACT, (3, 128), (0.75,), False),
    Event(Kind.POKE, (127, 255)),
    Event(Kind.SAVE),
    Event(Kind.RESTORE, (70_000,)),
    Event(Kind.LOAD, (0,)),
    Event(Kind.MODE, (12,)),
    Event(Kind.DIFFICULTY, (1,)),
    Event(Kind.STEP),
]


def some_plays(chunks: int = 3, frames: int = 100) -> list[PlayChunk]:
    plays, first = [], 0
    for number in range(chunks):
        checks = (first + frames) // 60 - first // 60
        plays.append(PlayChunk(first, bytes(i % 4 for i in range(frames)), tuple(range(checks)), bytes([number] * 7)))
        first += frames
    return plays


def write(path: Path, *, end: bool = True) -> Path:
    writer = ReplayFileWriter(path, {"game": "pong", "options": {}})
    for play in some_plays():
        writer.play(play)
    writer.snapshot(b"a snapshot")
    writer.end({"episodes": []}) if end else writer.close()
    return path


def test_events_come_back() -> None:
    assert unpack(pack(EVENTS)) == EVENTS
    assert unpack(pack([])) == []


def test_held_actions_take_little() -> None:
    steps = [Event(Kind.ACT, (action, 4), (), True) for action in (2, 3, 2, 5) * 15]
    assert len(pack(steps)) < 20


def test_too_many_actions_are_refused() -> None:
    assert unpack(pack([Event(Kind.ACT, (0, ACTS_PER_CHUNK))]))
    with pytest.raises(ValueError, match="more than 4096"):
        unpack(pack([Event(Kind.ACT, (0, ACTS_PER_CHUNK)), Event(Kind.ACT, (0, 1))]))


@pytest.mark.parametrize("seed", range(300))
def test_any_bytes_for_events_are_events_or_a_value_error(seed: int) -> None:
    generator = random.Random(seed)
    text = bytearray(zlib.decompress(pack(EVENTS), -15))
    for _ in range(generator.randint(1, 4)):
        text[generator.randrange(len(text))] = generator.randrange(256)
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    try:
        events = unpack(packer.compress(bytes(text[: generator.randint(1, len(text))])) + packer.flush())
    except ValueError:
        return
    assert all(isinstance(event, Event) for event in events)


def test_a_bomb_is_refused() -> None:
    packer = zlib.compressobj(9, zlib.DEFLATED, -15)
    bomb = packer.compress(bytes(1 << 26)) + packer.flush()
    with pytest.raises(ValueError, match="too many"):
        unpack(bomb)


def test_a_file_comes_back(tmp_path: Path) -> None:
    content = read(write(tmp_path / "a.a26r"))
    assert content.header == {"format": 1, "game": "pong", "options": {}}
    assert [play._replace(offset=0) for play in content.plays] == some_plays()
    assert content.snapshots == (b"a snapshot",)
    assert content.end == {"episodes": []}
    assert content.frames == 300


def test_a_file_cut_anywhere_gives_its_whole_chunks(tmp_path: Path) -> None:
    data = write(tmp_path / "a.a26r").read_bytes()
    offsets = [play.offset for play in read(tmp_path / "a.a26r").plays]
    ends = [*offsets[1:], offsets[2] + 11 + len(some_plays()[2].pack())]
    cut = tmp_path / "cut.a26r"
    for size in range(len(data)):
        cut.write_bytes(data[:size])
        if size < offsets[0]:
            with pytest.raises(Corrupt):
                read(cut)
            continue
        content = read(cut)
        assert content.end is None
        assert len(content.plays) == sum(size >= end for end in ends)


def test_a_changed_byte_is_noticed_with_its_offset(tmp_path: Path) -> None:
    path = write(tmp_path / "a.a26r")
    data = path.read_bytes()
    offsets = [play.offset for play in read(path).plays]
    for place in range(len(data)):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0x10]) + data[place + 1 :])
        with pytest.raises(Corrupt) as caught:
            read(path)
        if offsets[0] <= place < offsets[1]:
            assert f"at offset {offsets[0]}" in str(caught.value)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return record(tmp_path_factory.mktemp("replay") / "a.a26r", steps=8).read_bytes()


@pytest.mark.parametrize("seed", range(200))
def test_any_bytes_are_a_replay_or_a_value_error(recorded: bytes, tmp_path: Path, seed: int) -> None:
    generator, data, path = random.Random(seed), bytearray(recorded), tmp_path / "a.a26r"
    for _ in range(generator.randint(1, 6)):
        place = generator.randrange(8, len(data))
        kind = generator.randrange(3)
        if kind == 0:
            data[place] = generator.randrange(256)
        elif kind == 1:
            del data[place : place + generator.randint(1, 9)]
        else:
            data[place:place] = generator.randbytes(generator.randint(1, 9))
    path.write_bytes(_with_right_checksums(bytes(data)) if seed % 2 else bytes(data))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            Replay.load(path).verify()
        except ValueError:
            return


def _with_right_checksums(data: bytes) -> bytes:
    """The same with valid chunk heads, so that the payloads are read."""
    out, at = bytearray(data[:8]), 8
    while at + 11 <= len(data):
        kind, size = data[at : at + 1], int.from_bytes(data[at + 1 : at + 5], "little") % 4096
        payload = data[at + 11 : at + 11 + size]
        head = kind + len(payload).to_bytes(4, "little") + zlib.crc32(payload).to_bytes(4, "little")
        out += head + crc_hqx(head, 0).to_bytes(2, "little") + payload
        at += 11 + size
    return bytes(out)


def test_another_version_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_format, "FORMAT", 2)
    path = write(tmp_path / "a.a26r")
    monkeypatch.undo()
    with pytest.raises(Corrupt, match=r"^the replay has format 2, and this release of atari-envs reads 1"):
        read(path)


HEADER = b"H", b'{"format":1}'


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "is no replay of atari-envs"),
        (b"RIFF....WAVE", "is no replay of atari-envs"),
        (b"ATARIRPL", "ends within its header"),
        ([(b"P", b"")], "must be the first chunk"),
        ([HEADER, HEADER], "the only one of its kind"),
        ([(b"H", b"[1]")], "JSON object"),
        ([(b"H", b"[" * 100_000)], "nested more than 32 deep"),
        ([HEADER, (b"X", b"")], "no kind of chunk b'X'"),
        ([HEADER, (b"P", b"abc")], "too short"),
        ([HEADER, (b"P", b"\1\0\0\0\0\0\0\0")], "does not fit the chunk before"),
        ([HEADER, (b"E", b"{}"), (b"S", b"")], "after the end"),
    ],
)
def test_what_is_no_replay(tmp_path: Path, data: bytes | list[tuple[bytes, bytes]], text: str) -> None:
    if isinstance(data, list):
        data = b"ATARIRPL" + b"".join(file_format._chunk(*chunk) for chunk in data)
    (tmp_path / "a.a26r").write_bytes(data)
    with pytest.raises(Corrupt, match=text):
        read(tmp_path / "a.a26r")


def test_a_wrong_name_and_a_bad_place(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"must end in '\.a26r', got '.*a\.mp4'"):
        ReplayFileWriter(tmp_path / "a.mp4", {})
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        ReplayFileWriter(tmp_path / "file" / "a.a26r", {})
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]


def test_the_header_says_what_was_played(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "seaquest", 3, mode=0, frameskip=(2, 5), obs_type="ram")
    header = read(path).header
    named = [header[name] for name in ("game", "core", "source", "id", "rom")]
    assert named == ["seaquest", "native", "AtariEnv", None, "240bfbac5163af4df5ae713985386f92"]
    assert header["options"]["frameskip"] == [2, 5]
    assert Replay.load(path).options["frameskip"] == (2, 5)
