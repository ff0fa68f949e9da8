"""Run folders of strangers: flipped, cut and forged files, planted links, and several trainings in one folder."""

import json
import random
import shutil
import tempfile
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import torch
from crash_model import Disk
from crash_trainings import go_on, outcome, train

from atari.learning import load_policy
from atari.learning.run_folder import RunFolder
from attack.files import damaged

HOME = tempfile.TemporaryDirectory()
FILES = ("config.json", "policy.pt", "checkpoint.pt", "log.csv", "memory.replay")


@cache
def whole(agent: str) -> Path:
    """The folder of a training that was killed after its first checkpoints, with all its files."""
    path = Path(HOME.name, agent)
    assert not train(agent, path, Disk(path, 60))
    return path


@cache
def expected(agent: str) -> Any:
    path = Path(HOME.name, f"{agent}-ended")
    shutil.copytree(whole(agent), path)
    assert go_on(path)
    return outcome(path)


def refused(call: Callable[[], Any]) -> bool:
    """Whether a call raises one of the exceptions that docs/trust.md promises."""
    try:
        call()
    except (ValueError, OSError, ImportError):
        return True
    return False


def assert_equal(weights: dict[str, Any], others: dict[str, Any]) -> None:
    assert weights.keys() == others.keys()
    assert all(torch.equal(weights[name], value) for name, value in others.items())


def attack(seed: int) -> None:
    source = random.Random(seed)
    agent = source.choice(("ppo", "dqn"))
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder, "run")
        shutil.copytree(whole(agent), path)
        source.choice((attack_files, attack_files, attack_configuration, attack_links, attack_locks))(
            source, path, agent
        )


def attack_files(source: random.Random, path: Path, agent: str) -> None:
    """A damaged file is refused, or what is read from it is as before."""
    file = path / source.choice([name for name in FILES if (path / name).exists()])
    content = bytearray(file.read_bytes())
    if source.random() < 0.5:
        content[source.randrange(len(content))] ^= 1 << source.randrange(8)
    file.write_bytes(content if source.random() < 0.5 else damaged(source, bytes(content)))
    if not refused(lambda: load_policy(path)):
        assert_equal(RunFolder.open(path).load_weights(), RunFolder.open(whole(agent)).load_weights())
    if not refused(lambda: go_on(path)) and file.name != "config.json":  # its options and task have no checksum
        assert_equal(outcome(path)[0], expected(agent)[0])


def attack_configuration(source: random.Random, path: Path, agent: str) -> None:
    """Values of any kind: a ValueError, and nothing large is allocated."""
    config = json.loads((path / "config.json").read_text())
    values: list[Any] = [None, -1, 0, 2**63, 10**6, 10**30, 1.5, True, "x", "\x1b[2J", [], [1], {}, {"a": {}}, 1e300]
    table = config if source.random() < 0.3 else config[source.choice(("options", "task"))]
    key = source.choice(sorted(table))
    if source.random() < 0.1:
        table["more"] = source.choice(values)
    elif source.random() < 0.1:
        del table[key]
    else:
        table[key] = source.choice(values)
    (path / "config.json").write_text(json.dumps(config))
    before = largest()
    refused(lambda: load_policy(path)(np.zeros((1, 2, 42, 42), np.uint8), np.arange(1)))
    assert largest() - before < 2e9, config


def largest() -> float:
    """The most bytes of memory that this process has had."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024.0


def attack_links(source: random.Random, path: Path, agent: str) -> None:
    """Links at names that a training writes: their target stays as it is."""
    victim = path.parent / "victim"
    victim.write_bytes(b"mine")
    names = (
        "checkpoint.pt.part",
        "policy.pt.part",
        "policy.pt",
        "log.csv.part",
        "config.json.part",
        "memory.replay.part",
    )
    for name in source.sample((*names, "lock", "log.csv"), 3):
        (path / name).unlink(missing_ok=True)
        (path / name).symlink_to(victim)
    refused(lambda: go_on(path))
    assert victim.read_bytes() == b"mine"


def attack_locks(source: random.Random, path: Path, agent: str) -> None:
    """At most one training has the folder."""
    held: list[RunFolder] = []
    for _ in range(6):
        if held and source.random() < 0.4:
            held.pop().close()
            continue
        try:
            held.append(RunFolder.resume(path) if source.random() < 0.5 else RunFolder.open(path, lock=True))
        except BlockingIOError:
            assert held
        assert len(held) <= 1
    for folder in held:
        folder.close()
    assert go_on(path)
    assert_equal(outcome(path)[0], expected(agent)[0])
