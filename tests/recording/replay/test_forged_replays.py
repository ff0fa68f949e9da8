"""Replays with valid checksums whose header, end, events or snapshots were changed: ValueError, or a replay."""

import copy
import json
import os
import random
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from replay_tools import record

import atari
from atari.cores import snapshot
from atari.multiplayer import MultiplayerCore
from atari.recording import RecordReplay, Replay
from atari.recording.replay import file_format
from atari.recording.replay.events import ACTS_PER_CHUNK, Event, Kind, pack, unpack

VALUES: list[Any] = [
    KeyError, None, True, -1, 3, 2**40, 10**300, 0.5, float("nan"), "", "x", "/dev/zero.toml", [], [[]], [1], [3, 2],
    {}, {"frames": 1}, [{"frames": 1, "score": "x", "end": 3}], 2.0,
]  # fmt: skip


_DEFINITIONS = [
    b'{"to": 3, "value": "old + random(0, 3)"}',
    b"",
    b"?",
    b"[]",
    b"{}",
    b"[" * 100_000,
    b'{"to": 3}',
    b'{"to": 3, "value": 1, "where": 2}',
    b'{"to": 256, "value": 1}',
    b'{"to": "ball_q", "value": 1}',
    b'{"to": 3, "value": null}',
    b'{"to": 3, "value": "print(1)"}',
    b'{"to": 3, "value": 1, "mask": 0}',
    b'{"to": 3, "value": 1, "mask": true}',
    b'{"to": 3, "value": 1, "when": "never"}',
    b'{"to": 3, "value": 1, "when": [-1]}',
    b'{"to": 3, "value": 1, "when": [0.5]}',
    b'{"to": 3, "value": 1, "once": 1}',
    b'{"to": 3, "value": 1, "condition": "ram[256]"}',
    b'{"to": 3, "value": "' + b"-" * 5000 + b'1"}',
]
"""Writes of replays; all but the first are wrong."""


@pytest.fixture(scope="module")
def content(tmp_path_factory: pytest.TempPathFactory) -> file_format.ReplayContent:
    """What a good replay has."""
    return file_format.read(record(tmp_path_factory.mktemp("replay") / "a.a26r", steps=3))


def write(path: Path, *chunks: tuple[bytes, bytes]) -> Path:
    path.write_bytes(b"ATARIRPL" + b"".join(file_format._chunk(*chunk) for chunk in chunks))
    return path


def use(path: Path, core: str = "native") -> bool:
    """Whether a replay could be used in every way; it must raise nothing but ValueError."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            replay = Replay.load(path)
            if replay.players == 1:
                replay.make_env().close()
            assert isinstance(repr((replay.options, replay.episodes, replay.seeds, dict(replay.header))), str)
            replay.verify(core)
        except ValueError:
            return False
    return True


def changed(facts: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The header or the end of a replay with one value changed, removed or added."""
    places = [(name,) for name in (*facts, "more")] + [("options", name) for name in facts.get("options", ())]
    places += [("options", name) for name in ("core", "rom", "game", "render_mode", "self", "sound", "x")]
    places += [("episodes", 0, name) for name in ("score", "scores", "frames", "end", "more")]
    for path in places:
        for value in VALUES:
            inner = copied = copy.deepcopy(facts)
            for place in path[:-1]:
                inner = inner[place] if place in inner or isinstance(inner, list) else {}
            if value is KeyError:
                inner.pop(path[-1], None)
            else:
                inner[path[-1]] = value
            if copied != facts:
                yield copied


def record_match(path: Path, frames: int = 20) -> Path:
    with RecordReplay(MultiplayerCore("pong"), path) as match:
        match.reset()
        for frame in range(frames):
            match.act_players([frame % 18, 1])
    return path


@pytest.mark.parametrize("players", [1, 2])
def test_headers_and_ends(players: int, tmp_path: Path, content: file_format.ReplayContent) -> None:
    path = tmp_path / "a.a26r"
    content = content if players == 1 else file_format.read(record_match(path))
    header, end = content.header, content.end
    assert end is not None
    results = []
    for head, last in [*((other, end) for other in changed(header)), *((header, other) for other in changed(end))]:
        chunks = (b"H", json.dumps(head).encode()), (b"P", content.plays[0].pack()), (b"E", json.dumps(last).encode())
        results.append(use(write(tmp_path / "b.a26r", *chunks)))
    assert results.count(False) > 150
    assert results.count(True) > 10


@pytest.mark.parametrize("core", ["native", "ale"])
def test_events(tmp_path: Path, content: file_format.ReplayContent, core: str) -> None:
    header = (b"H", json.dumps(content.header).encode())
    rng = random.Random(0)
    for _ in range(150 if core == "native" else 15):
        events = [Event(Kind.RESET)]
        for _ in range(rng.randint(1, 6)):
            kind = rng.choice([kind for kind in Kind if kind not in (Kind.ACT, Kind.CONTINUOUS_ACTION)])
            numbers = tuple(rng.choice([0, 1, 127, 128, 2**32 - 1, 2**34]) for _ in range(2))
            count = {Kind.POKE: 2, Kind.ADD_WRITE: 2, Kind.RESET: 0, Kind.SAVE: 0, Kind.STEP: 0}.get(kind, 1)
            strength = (rng.choice([float("nan"), float("inf"), 1e30, -0.5]),)
            events += [Event(kind, numbers[:count]), Event(Kind.ACT, (rng.randrange(18), 2), strength)]
        play = file_format.PlayChunk(0, bytes(12), (), pack(events)).pack()
        definition = rng.choice(_DEFINITIONS)
        use(write(tmp_path / "b.a26r", header, (b"W", definition), (b"P", play)), core)


@pytest.mark.parametrize("definition", _DEFINITIONS[1:])
def test_a_forged_write_is_refused(definition: bytes, tmp_path: Path, content: file_format.ReplayContent) -> None:
    header = (b"H", json.dumps(content.header).encode())
    for events, good in (([Event(Kind.RESET)], True), ([Event(Kind.ADD_WRITE, (0, 1))], False)):
        play = file_format.PlayChunk(0, b"", (), pack(events)).pack()
        assert use(write(tmp_path / "b.a26r", header, (b"W", definition), (b"P", play))) == good


def test_snapshots(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "a.a26r")
    other = atari.AtariEnv("breakout")
    other.reset(seed=1)
    env.reset(seed=0)
    env.unwrapped.restore(other.snapshot())
    env.step(0)
    env.close()
    content = file_format.read(tmp_path / "a.a26r")
    (good,) = content.snapshots
    assert use(tmp_path / "a.a26r")
    facts, blobs = snapshot.unpack(good)
    header, plays = (b"H", json.dumps(content.header).encode()), [(b"P", play.pack()) for play in content.plays]
    for forged in (
        b"",
        b"?",
        good[:-1],
        snapshot.pack({}, {}),
        snapshot.pack(facts, {}),
        snapshot.pack({**facts, "game": []}, blobs),
        snapshot.pack(facts, {"state": b"?"}),
    ):
        assert not use(write(tmp_path / "b.a26r", header, plays[0], (b"S", forged), *plays[1:]))


def test_a_replay_does_not_choose_files(tmp_path: Path, content: file_format.ReplayContent) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    header = {**content.header, "game": str(tmp_path / "pipe.toml")}
    write(tmp_path / "b.a26r", (b"H", json.dumps(header).encode()))
    with pytest.raises(ValueError, match=r"there is no game '.*pipe\.toml'.*pass the game file .* as game="):
        Replay.load(tmp_path / "b.a26r")


def test_pipes_and_devices_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.a26r")
    (tmp_path / "device.a26r").symlink_to("/dev/zero")
    for name in ("pipe", "device"):
        with pytest.raises(ValueError, match=rf"{name}\.a26r is a device or a pipe; give a regular file"):
            Replay.load(tmp_path / f"{name}.a26r")


def test_events_of_several_players(tmp_path: Path) -> None:
    content = file_format.read(record_match(tmp_path / "a.a26r"))
    header = b"H", json.dumps(content.header).encode()
    events = unpack(content.plays[0].events)
    wrong = [
        [Event(Kind.ACT, (1, 5))],
        [Event(Kind.ACTIONS, (18**2, 1))],
        [Event(Kind.ACTIONS, (0, ACTS_PER_CHUNK + 1))],
        *[[Event(kind, (1,))] for kind in (Kind.MODE, Kind.DIFFICULTY, Kind.REMOVE_WRITE, Kind.LOAD, Kind.RESTORE)],
        [Event(Kind.ADD_WRITE, (0, 0))],
        [Event(Kind.POKE, (128, 0))],
        [Event(Kind.SEED, (2**32 - 1,)), Event(Kind.RESTORE, (1,))],
        [Event(Kind.CONTINUOUS_ACTION, (), (1.0, 1.0, 1.0))],
    ]
    for change in wrong:
        chunk = content.plays[0]._replace(events=pack([*change, *events]))
        assert not use(write(tmp_path / "b.a26r", header, (b"P", chunk.pack()))), change
    data = (tmp_path / "a.a26r").read_bytes()
    source = random.Random(1)
    for size in source.sample(range(len(data)), 60):
        (tmp_path / "b.a26r").write_bytes(data[:size])
        use(tmp_path / "b.a26r")
    for _ in range(60):
        damaged = bytearray(data)
        damaged[source.randrange(len(data))] ^= 1 << source.randrange(8)
        (tmp_path / "b.a26r").write_bytes(damaged)
        assert not use(tmp_path / "b.a26r")


def test_actions_of_several_players_in_a_replay_of_one_are_refused(
    tmp_path: Path, content: file_format.ReplayContent
) -> None:
    chunk = content.plays[0]._replace(events=pack([Event(Kind.ACTIONS, (0, 1)), *unpack(content.plays[0].events)]))
    header = b"H", json.dumps(content.header).encode()
    assert not use(write(tmp_path / "b.a26r", header, (b"P", chunk.pack())))
    several = b"H", json.dumps({**content.header, "players": 2}).encode()
    assert not use(write(tmp_path / "b.a26r", several, (b"P", content.plays[0].pack())))
