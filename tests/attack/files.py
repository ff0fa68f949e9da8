"""Damaged and forged files: snapshots, replays, game definitions, ROM images and archives."""

import contextlib
import io
import random
import re
import tarfile
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import atari
from atari import roms
from atari.cores import snapshot
from atari.lab import Freeze, Poke
from atari.recording import RecordReplay, Replay
from atari.recording.replay import file_format
from atari.roms import search
from atari.roms.locations import path as own_folder
from attack.findings import ALLOWED, attempt


def damaged(source: random.Random, content: bytes) -> bytes:
    """The content with bytes replaced, removed, doubled or cut off."""
    made = bytearray(content)
    for _ in range(source.choice((1, 1, 3, 20))):
        place = source.randrange(len(made) + 1)
        match source.randrange(4):
            case 0:
                made[place : place + 1] = source.randbytes(1)
            case 1:
                del made[place : place + source.choice((1, 8, 500))]
            case 2:
                made[place:place] = made[place : place + source.choice((1, 64))]
            case 3:
                made[place : place + 4] = source.choice((b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff", b"-1e9", b"[[[["))
    return bytes(made)


def forged(source: random.Random, content: bytes) -> bytes:
    """A snapshot with a right checksum and wrong facts or blobs."""
    facts, blobs = snapshot.unpack(content)
    facts.pop("blobs", None)
    key = source.choice(sorted(facts))
    values: list[Any] = [None, -1, 2**70, "x", [], {}, 1.5, True, [[[]]], {"a": {"b": 1}}]
    if source.random() < 0.3:
        del facts[key]
    elif isinstance(facts[key], dict) and facts[key] and source.random() < 0.7:
        facts[key] = {**facts[key], source.choice(sorted(facts[key])): source.choice(values)}
    else:
        facts[key] = source.choice(values)
    name = source.choice(sorted(blobs))
    if source.random() < 0.3:
        blobs[name] = damaged(source, blobs[name])
    return snapshot.pack(facts, blobs)


def attack(seed: int) -> None:
    """One round of each kind of file."""
    source = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        attack_snapshots(source)
        attack_replays(source, folder)
        attack_definitions(source, folder)
        attack_archives(source, folder)
        attack_names(source, folder / "names")


def attack_snapshots(source: random.Random) -> None:
    """A refused snapshot leaves the environment as it was."""
    env = atari.AtariEnv("pong", obs_type="ram")
    env.reset(seed=1)
    for _ in range(30):
        env.step(source.randrange(6))
    good = env.snapshot()
    for make in (damaged, forged, forged):
        try:
            env.restore(make(source, good))
        except (TypeError, ValueError):
            assert env.snapshot() == good, "a refused snapshot has changed the environment"
        else:
            env.restore(good)


def attack_replays(source: random.Random, folder: Path) -> None:
    """A damaged replay is refused, or read."""
    path = folder / f"a{file_format.SUFFIX}"
    env = RecordReplay(atari.AtariEnv("pong", obs_type="ram"), path)
    env.reset(seed=2)
    for _ in range(10):
        env.step(source.randrange(6))
    with Freeze(env, {source.randrange(128): "old + random(0, 3)"}):
        Poke(env, {source.randrange(128): source.randrange(256)}, frame=60)
        for _ in range(10):
            env.step(source.randrange(6))
    env.close()
    files = sorted(folder.rglob(f"*{file_format.SUFFIX}"))
    assert files, "no replay was written"
    if source.random() < 0.5:
        forge_writes(source, files[0])
    else:
        files[0].write_bytes(damaged(source, files[0].read_bytes()))
    attempt(lambda: [frame.reward for frame in Replay.load(files[0]).frames()])


def forge_writes(source: random.Random, path: Path) -> None:
    """Damage the definitions of a replay's writes; the checksums are right."""
    content = file_format.read(path)
    writer = file_format.ReplayFileWriter(path, content.header)
    for definition in content.writes:
        writer.write(damaged(source, definition.encode()).decode(errors="replace"))
    for play in content.plays:
        writer.play(play)
    writer.close()


def attack_definitions(source: random.Random, folder: Path) -> None:
    """A damaged game definition is refused, or makes an environment that runs."""
    definition = Path(atari.games.__path__[0], "data", source.choice(("pong.toml", "seaquest.toml", "qbert.toml")))
    text = damaged(source, definition.read_bytes())
    (folder / "own.toml").write_bytes(text)
    (folder / "own.bin").write_bytes(source.randbytes(4096))

    def play() -> None:
        env = atari.AtariEnv(str(folder / "own.toml"), rom=folder / "own.bin")
        observation, _ = env.reset(seed=0)
        assert env.observation_space.contains(observation), "the observation is not in its space"
        for _ in range(5):
            env.step(0)

    attempt(play)


def attack_archives(source: random.Random, folder: Path) -> None:
    """An import of a folder with a damaged archive in it ends, and stores no wrong image."""
    content = archive_of(source, source.randrange(5))
    given = folder / "given"
    given.mkdir()
    (given / "roms").write_bytes(damaged(source, content))
    before = sorted(own_folder().glob("*"))
    with contextlib.suppress(*ALLOWED):
        roms.import_from(given)
    assert sorted(own_folder().glob("*")) == before, "an image that is of no game was stored"


def attack_names(source: random.Random, folder: Path) -> None:
    """A file is what it contains, whatever its name and its neighbours are: a replay is never played as a ROM."""
    folder.mkdir()
    definition, image = folder / "own.toml", source.randbytes(4096)
    text = Path(atari.games.__path__[0], "data", "pong.toml").read_text(encoding="utf-8")
    definition.write_text(re.sub(r"\[rom\][^[]*", "", text), encoding="utf-8")  # without hashes, any image will do
    endings = (file_format.SUFFIX, *search.ENDINGS)
    replay = folder / f"own{file_format.SUFFIX}"
    env = RecordReplay(atari.AtariEnv("pong", obs_type="ram"), replay)
    env.reset(seed=source.randrange(100))
    env.close()
    name, other = source.sample(endings, 2)
    replay = replay.rename(replay.with_suffix(name))
    assert Replay.load(replay).verify(), f"a replay named {replay.name} does not open"
    try:
        atari.AtariEnv(definition)
    except FileNotFoundError:
        pass
    else:
        raise AssertionError(f"the replay {replay.name} was taken for the ROM of {definition.name}")
    definition.with_suffix(other).write_bytes(image)
    if other in search.ENDINGS:
        found = roms.find(atari.games.resolve(definition))
        assert found.read_bytes() == image, f"{found.name} was taken for the ROM in place of own{other}"


def archive_of(source: random.Random, depth: int) -> bytes:
    """A zip or tar archive of random files and, up to a depth, of archives that may be damaged."""
    names = ("a.bin", "../b.bin", "/c.bin", "d/e.a26", "", "f.zip")
    members = [(name, source.randbytes(5000)) for name in source.sample(names, source.randrange(4))]
    if depth:
        inner = archive_of(source, depth - 1)
        members.append(("inner", source.choice((inner, damaged(source, inner)))))
    content = io.BytesIO()
    if source.random() < 0.5:
        with zipfile.ZipFile(content, "w", source.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
            for name, data in members:
                archive.writestr(name or "x", data)
        return content.getvalue()
    formats = (tarfile.USTAR_FORMAT, tarfile.GNU_FORMAT, tarfile.PAX_FORMAT)
    kinds = (tarfile.REGTYPE, tarfile.REGTYPE, tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.GNUTYPE_SPARSE)
    with tarfile.open(fileobj=content, mode=source.choice(("w", "w:gz")), format=source.choice(formats)) as tar:
        for name, data in members:
            info = tarfile.TarInfo(name)
            info.type, info.linkname, info.size = source.choice(kinds), "/etc/passwd", len(data)
            tar.addfile(info, io.BytesIO(data))
    return content.getvalue()
