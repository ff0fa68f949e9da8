"""Every file that the package writes: planted links are not followed, and a flipped bit is found when it is read."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.cores import verify
from atari.lab import write_dataset
from atari.lab.causal import files as causal_files
from atari.lab.causal.explore import causes
from atari.lab.causal.picture import write_png
from atari.lab.inspector.export import write
from atari.lab.inspector.sources import session_of_snapshot
from atari.learning import PROTOCOLS, Result, compare
from atari.learning.evaluation.results import GameResult
from atari.play import Session
from atari.recording import RecordReplay, Replay, VideoWriter


def result() -> Result:
    games = [GameResult(one, (1.0, 5.0), (9, 9), (False, False), (0, 1)) for one in ("pong", "breakout")]
    return Result("mine", PROTOCOLS["dopamine"], 0, tuple(games))


def screen(file: Path) -> None:
    with atari.AtariEnv("breakout") as env:
        env.reset(seed=0)
        env.ale.saveScreenPNG(file)


def replay(file: Path) -> None:
    with RecordReplay(atari.AtariEnv("breakout"), file) as env:
        env.reset(seed=0)
        env.step(1)


def video(file: Path) -> None:
    with VideoWriter(file, (16, 16), 60, scale=1) as writer:
        writer.write(np.zeros((16, 16, 3), np.uint8))


def numbered_pictures(file: Path) -> None:
    video(file.with_name(file.name.replace("000000", "%06d")))


def saved_state(file: Path) -> None:
    session = Session("breakout", state=file)
    session.save()
    session.close()


def exported(file: Path) -> None:
    with atari.AtariEnv("breakout", frameskip=1) as env:
        env.reset(seed=0)
        file.with_name("source.state").write_bytes(env.snapshot())
    session = session_of_snapshot(file.with_name("source.state"))
    session.freeze(49)
    write(session, file.name, file)


def data_set(file: Path) -> None:
    replay(file.with_name("source.a26r"))
    write_dataset(file.with_name("source.a26r"), file, frames="grayscale", labels=[])


WRITERS: dict[str, Callable[[Path], Any]] = {
    "result.json": lambda file: result().save(file),
    "comparison.json": lambda file: compare(result()).save(file),
    "comparison.svg": lambda file: compare(result()).plot(file),
    "map.npz": lambda file: causal_files.save(causes("breakout", 1, 1, 1, threads=1), file),
    "map.png": lambda file: write_png(causes("breakout", 1, 1, 1, threads=1), file),
    "difference-pong-0-3.json": lambda file: verify.Difference(verify.Run("pong"), 3).write(file.parent),
    "screen.png": screen,
    "a.a26r": replay,
    "a.mp4": video,
    "p000000.png": numbered_pictures,
    "a.state": saved_state,
    "interventions.toml": exported,
}


NEEDS = {"a.mp4": "av", "comparison.svg": "matplotlib"}


@pytest.mark.parametrize("name", WRITERS)
def test_a_planted_link_is_not_followed(name: str, tmp_path: Path) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name], reason=f"{NEEDS[name]} is not installed")
    victim = tmp_path / "victim"
    victim.write_text("mine")
    for link in (name, f"{name}.part"):
        (tmp_path / link).symlink_to(victim)
    WRITERS[name](tmp_path / name)
    assert victim.read_text() == "mine"
    assert not (tmp_path / name).is_symlink()
    assert (tmp_path / name).stat().st_size > 10


READERS: dict[str, Callable[[Path], Any]] = {
    "a.a26r": lambda file: (Replay.load(file).header, Replay.load(file).episodes),
    "a.state": lambda file: Session("breakout", state=file).load(),
    "map.npz": lambda file: [vars(byte) | {"pixels": byte.pixels.tolist()} for byte in causal_files.load(file).bytes],
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.filterwarnings("ignore")
def test_a_flipped_bit_is_found(name: str, tmp_path: Path) -> None:
    file, read = tmp_path / name, READERS[name]
    WRITERS[name](file)
    good, data, generator = read(file), file.read_bytes(), random.Random(0)
    refused = 0
    for _ in range(200):
        flipped = bytearray(data)
        flipped[generator.randrange(len(data))] ^= 1 << generator.randrange(8)
        file.write_bytes(flipped)
        try:
            assert read(file) == good  # such as the date of a member of a zip archive
        except ValueError:
            refused += 1
    assert refused > 100


@pytest.mark.parametrize("ending", [".h5", ".parquet"])
def test_data_sets_replace_no_link(ending: str, tmp_path: Path) -> None:
    pytest.importorskip("h5py" if ending == ".h5" else "pyarrow", reason="the format needs it")
    (tmp_path / "victim").write_text("mine")
    (tmp_path / f"a{ending}.part").symlink_to("victim")
    data_set(tmp_path / f"a{ending}")
    assert (tmp_path / "victim").read_text() == "mine"
    assert not (tmp_path / f"a{ending}").is_symlink()
