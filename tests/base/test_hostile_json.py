"""Every reader of JSON from a file: hostile texts are refused with one sentence, and nothing large is allocated."""

import contextlib
import io
import json
import resource
import sys
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import gymnasium
import numpy as np
import pytest

import atari
from atari.base import json_text
from atari.cores import AleCore, NativeCore, snapshot, verify
from atari.cores.writes import write_of
from atari.lab.causal import files as causal_files
from atari.lab.causal.explore import causes
from atari.learning import PROTOCOLS, Result, load_policy
from atari.learning.evaluation.results import GameResult
from atari.policy.needs import needs_of
from atari.recording import RecordReplay, Replay, VideoWriter, video_facts
from atari.recording.replay import file_format
from atari.task.arguments import read_task

GENERAL: tuple[bytes, ...] = (
    b"", b"{", b"null", b"[]", b"1", b'"x"', b"true", b"[" * 100_000, b"[" * 60 + b"]" * 60, b'{"a":' * 100_000,
    b"NaN", b'{"a": -Infinity}', b'{"a": 1e999}', b"1" + b"0" * 10_000, b'{"a": 1, "a": 1}', b'{"a": "\\ud800"}',
    b'{"a": "\\u001b[2J"}', b"\xff\xfe{\x00", b"[" + b"0," * 40_000_000 + b"0]",
)  # fmt: skip
"""Texts that no reader takes; the last is a large one."""

VALUES: tuple[Any, ...] = (
    None, True, -1, 0, 2**63, 10**9, 1e300, 1.5, "", "x", "../x", [], {}, [[]], [None], [{}], {"x": []}, [1, 2, 3]
)  # fmt: skip


@dataclass(frozen=True)
class Reader:
    """A reader of JSON.

    Attributes:
        good: a table that it reads.
        read: reads a text in place of this table, and uses what it has read.
        check_unchanged: checks that a refused text has changed nothing.
        values: in place of each part of the table.
        least: how many tables with such a value are refused at least.
        texts: that are refused.
    """

    good: dict[str, Any]
    read: Callable[[bytes], object]
    check_unchanged: Callable[[], object] = lambda: None
    values: tuple[Any, ...] = VALUES
    least: int = 0
    texts: tuple[bytes, ...] = GENERAL


def of_task(folder: Path) -> Reader:
    game = atari.Task.of("pong", preset="dqn2015", interventions=["lazy_enemy"])
    good = json.loads(game.to_json())
    return Reader(good, lambda text: atari.Task.from_json(text.decode(errors="surrogateescape")))


def of_task_file(folder: Path) -> Reader:
    return Reader(json.loads(atari.Task("pong").to_json()), lambda text: read_task(written(folder / "task.json", text)))


BLOBS = ([["core", -1]], [["core", 10**30]], [[["core"], 1]], [["core", 1, 2]], {"state": {}}, 2**31, 2**64, 10**300)
"""Values for the facts of a snapshot, too; some name the blobs after the facts."""


def snapshot_of(played: Any, inner: str = "", texts: tuple[bytes, ...] = GENERAL) -> Reader:
    """A reader of the facts of a snapshot, or of those of a snapshot that is a blob in it."""
    played.reset()
    whole = played.snapshot()
    facts, blobs = snapshot.unpack(whole)
    data = blobs[inner] if inner else whole
    size = int.from_bytes(data[26:30], "little")

    def read(text: bytes) -> None:
        body = len(text).to_bytes(4, "little") + text + data[30 + size :]
        forged = data[:10] + snapshot._digest(body) + body
        played.restore(snapshot.pack(facts, {**blobs, inner: forged}) if inner else forged)
        if played.snapshot() != whole:
            played.restore(whole)

    def check_unchanged() -> None:
        assert played.snapshot() == whole

    return Reader(json.loads(data[30 : 30 + size]), read, check_unchanged, (*VALUES, *BLOBS), 300, texts)


def replay_with(folder: Path, kind: bytes) -> Reader:
    """A reader of one kind of chunk of a replay."""
    with RecordReplay(atari.AtariEnv("pong", interventions=["lazy_enemy"]), folder / "a.a26r") as env:
        env.reset(seed=0)
        env.step(2)
    chunks = list(file_format._chunks(folder / "a.a26r"))
    (good,) = [json.loads(payload) for _, one, payload in chunks if one == kind]

    def read(text: bytes) -> None:
        packed = (file_format._chunk(one, text if one == kind else payload) for _, one, payload in chunks)
        replay = Replay.load(written(folder / "b.a26r", b"ATARIRPL" + b"".join(packed)))
        assert isinstance(replay.episodes, tuple)
        assert replay.facts
        assert replay.task

    return Reader(good, read)


def of_write(folder: Path) -> Reader:
    good = {"to": 57, "value": "old", "when": [1, 2], "condition": "frame > 3", "mask": 15, "once": True}
    game = atari.games["breakout"]
    return Reader(good, lambda text: write_of(game, text.decode(errors="surrogateescape")))


def of_video(folder: Path) -> Reader:
    pytest.importorskip("av", reason="PyAV is not installed")

    def read(text: bytes) -> None:
        comment = text[: 1 << 20].decode(errors="replace").replace("\0", "")
        with VideoWriter(folder / "a.mkv", (16, 16), 60, scale=1, comment=comment) as video:
            video.write(np.zeros((16, 16, 3), np.uint8))
        video_facts(folder / "a.mkv")

    return Reader({"task": {"game": "pong"}, "package": "atari-envs 1"}, read)


def of_difference(folder: Path) -> Reader:
    good = json.loads(json.dumps(asdict(verify.Difference(verify.VerificationRun("pong"), 3, ("lives 1 and 2",)))))
    return Reader(good, lambda text: verify.read(written(folder / "a.json", text)))


def of_result(folder: Path) -> Reader:
    game = GameResult("pong", (1.0, 2.0), (4, 5), (False, True), (5, 6), {"stack_num": 4})
    good = json.loads(json.dumps(Result("mine", PROTOCOLS["dopamine"], 3, (game,), None, {"numpy": "2"}).to_json()))

    def read(text: bytes) -> None:
        with contextlib.suppress(ValueError, RecursionError):  # a new checksum, as the old one would find every change
            content = json.loads(text) if len(text) < 1 << 20 else None
            text = json.dumps(json_text.seal(content)).encode() if isinstance(content, dict) else text
        str(Result.load(written(folder / "a.json", text)))

    return Reader(good, read)


def of_causal_map(folder: Path) -> Reader:
    arrays = causal_files.to_arrays(causes("breakout", 2, 1, 1, threads=1))

    def read(text: bytes) -> None:
        memory = io.BytesIO()
        np.savez_compressed(memory, allow_pickle=False, **{**arrays, "facts": np.frombuffer(text, np.uint8)})
        causal_files.load(written(folder / "a.npz", memory.getvalue()))

    good = json.loads(arrays["facts"].tobytes())
    good["suggestions"] = [{"index": 1, "kind": "lives", "support": 3, "share": 0.5}]
    return Reader(good, read)


def of_sb3_model(folder: Path) -> Reader:
    def read(text: bytes) -> None:
        with zipfile.ZipFile(folder / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("_stable_baselines3_version", "2")
            archive.writestr("data", text)
        absent = mock.patch.dict(sys.modules, {"stable_baselines3": None})  # it would refuse a model without weights
        with absent, pytest.raises((ValueError, gymnasium.error.DependencyNotInstalled)) as caught:
            load_policy(folder / "a.zip")
        if isinstance(caught.value, ValueError):
            raise caught.value

    return Reader({"policy_class": {"__module__": "x"}, "clip_range": 1, "num_timesteps": 5}, read)


def of_torch_script(folder: Path) -> Reader:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    network = torch.jit.trace(torch.nn.Linear(1, 1), torch.zeros(1, 1))

    def read(text: bytes) -> None:
        extra = {"environment.json": text[: 2 << 20] or b" "}  # an empty one is none
        network.save(str(folder / "a.pt"), _extra_files=extra)
        needs_of(load_policy(folder / "a.pt"), atari.games["pong"])

    return Reader({"preset": "baselines", "img_height": 42, "img_width": 42}, read)


READERS: dict[str, Callable[[Path], Reader]] = {
    "a snapshot": lambda folder: snapshot_of(atari.AtariEnv("breakout", frameskip=(2, 5))),
    "the core in a snapshot": lambda folder: snapshot_of(atari.AtariEnv("breakout"), "core", GENERAL[:-1]),
    "a core's snapshot": lambda folder: snapshot_of(NativeCore("breakout", seed=0)),
    "a snapshot of ale-py's core": lambda folder: snapshot_of(AleCore("breakout", seed=0), "", GENERAL[:-1]),
    "a replay's header": lambda folder: replay_with(folder, b"H"),
    "a replay's end": lambda folder: replay_with(folder, b"E"),
    **{read.__name__: read for read in (of_task, of_task_file, of_write, of_video, of_difference, of_result)},
    **{read.__name__: read for read in (of_causal_map, of_sb3_model, of_torch_script)},
}


def written(file: Path, data: bytes) -> Path:
    file.write_bytes(data)
    return file


def changed(value: Any, values: tuple[Any, ...]) -> Iterator[Any]:
    """The value with each part of it missing, or another one, and with another key; alone, with one part."""
    if isinstance(value, dict):
        yield {**value, "another": 1}
        for key, one in value.items():
            yield {name: other for name, other in value.items() if name != key}
            yield {key: one}
            for new in [*values, *changed(one, values)]:
                yield {**value, key: new}
    elif isinstance(value, list) and value:
        yield value[1:]
        yield [*value, value[0]]
        for new in [*values, *changed(value[0], values)]:
            yield [new, *value[1:]]


@pytest.mark.parametrize("name", READERS)
@pytest.mark.filterwarnings("ignore")
def test_hostile_texts(name: str, tmp_path: Path) -> None:
    reader = READERS[name](tmp_path)
    reader.read(json.dumps(reader.good).encode())
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for text in reader.texts:
        with pytest.raises(ValueError, match=r"(?s)^.{20,600}$"):
            reader.read(text)
        reader.check_unchanged()
    refused = 0
    for value in changed(reader.good, reader.values):
        try:
            reader.read(json.dumps(value).encode())
        except ValueError:
            reader.check_unchanged()
            refused += 1
    assert refused >= reader.least
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 600 << 10, f"{grown:,} KB"
