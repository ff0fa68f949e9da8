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
from atari.recording import RecordReplay, Replay
from atari.recording.replay import file_format
from atari.recording.replay.events import Event, Kind, pack

VALUES: list[Any] = [
    KeyError, None, True, -1, 3, 2**40, 10**300, 0.5, float("nan"), "", "x", "/dev/zero.toml", [], [[]], [1], [3, 2],
    {}, {"frames": 1}, [{"frames": 1, "score": "x", "end": 3}],
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


def write(path: Path, *chunks: tuple[bytes, bytes]) -> Path:
    path.write_bytes(b"ATARIRPL" + b"".join(file_format._chunk(*chunk) for chunk in chunks))
    return path


def use(path: Path, core: str = "native") -> bool:
    """Whether a replay could be used in every way; it must raise nothing but ValueError."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            replay = Replay.load(path)
            replay.make_env().close()
            assert isinstance(repr((replay.options, replay.episodes, dict(replay.header))), str)
            replay.verify(core)
        except ValueError:
            return False
    return True


def changed(facts: dict[str, Any]) -> Iterator[dict[str, Any]]:
    for path in [(name,) for name in facts] + [("options", name) for name in facts.get("options", ())]:
        for value in VALUES:
            copied = copy.deepcopy(facts)
            inner = copied if len(path) == 1 else copied["options"]
            if value is KeyError:
                del inner[path[-1]]
            else:
                inner[path[-1]] = value
            yield copied
    for name in ("core", "rom", "game", "render_mode", "self", "color_averaging", "x"):
        if "options" in facts:
            yield {**facts, "options": {**facts["options"], name: "human"}}
    yield {**facts, "more": [[[[]]]]}


def test_headers_and_ends(tmp_path: Path) -> None:
    content = file_format.read(record(tmp_path / "a.a26r", steps=3))
    play = content.plays[0].pack()
    end = {"episodes": [], "check": 0} if content.end is None else content.end
    results = []
    for header in changed(content.header):
        chunks = (b"H", json.dumps(header).encode()), (b"P", play), (b"E", json.dumps(end).encode())
        results.append(use(write(tmp_path / "b.a26r", *chunks)))
    for other in changed(end):
        chunks = (b"H", json.dumps(content.header).encode()), (b"P", play), (b"E", json.dumps(other).encode())
        results.append(use(write(tmp_path / "b.a26r", *chunks)))
    assert results.count(False) > 150
    assert results.count(True) > 10


@pytest.mark.parametrize("core", ["native", "ale"])
def test_events(tmp_path: Path, core: str) -> None:
    content = file_format.read(record(tmp_path / "a.a26r", steps=3))
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
def test_a_forged_write_is_refused(definition: bytes, tmp_path: Path) -> None:
    content = file_format.read(record(tmp_path / "a.a26r", steps=3))
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


def test_a_replay_does_not_choose_files(tmp_path: Path) -> None:
    content = file_format.read(record(tmp_path / "a.a26r", steps=3))
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
