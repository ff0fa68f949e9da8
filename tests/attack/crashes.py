"""Trainings that are killed, lose power or have a full disk, at any durable operation, once or twice."""

import random
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from crash_model import Disk
from crash_trainings import Outcome, assert_ends_or_says_so, assert_goes_on, go_on, outcome, train

KINDS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("ppo", {}),
    ("pqn", {}),
    ("dqn", {}),
    ("dqn", {"priority": 0.5, "n_step": 3}),
    ("dqn", {"compress": True, "num_envs": 8}),
    ("dqn", {"checkpoint_minutes": 60.0, "total_steps": 800}),  # only the memory demands checkpoints
    ("dqn", {"checkpoint_minutes": 60.0, "obs_type": "ram", "keep_memory": True, "total_steps": 800}),
)


@cache
def whole(kind: int) -> tuple[Disk, Outcome]:
    """The disk and the outcome of a training that nothing stops."""
    agent, options = KINDS[kind]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run")
        disk = Disk(path, -1)
        assert train(agent, path, disk, **options)
        return disk, outcome(path)


def attack(seed: int) -> None:
    """One training of one kind."""
    source = random.Random(seed)
    kind = source.randrange(len(KINDS))
    disk, expected = whole(kind)
    with tempfile.TemporaryDirectory() as folder:
        if source.random() < 0.2:
            fill(source, Path(folder), kind, disk, expected)
        else:
            crash(source, Path(folder), kind, disk, expected)


def crash(source: random.Random, folder: Path, kind: int, disk: Disk, expected: Outcome) -> None:
    """Stop a training, and perhaps the one that goes on from there."""
    agent, options = KINDS[kind]
    path, image, number = folder / "run", folder / "image", source.randrange(disk.count)
    lost = random.Random(source.random()) if source.random() < 0.6 else None
    assert not train(agent, path, Disk(path, number, image, lost), **options)
    certain = disk.first_config is not None and number >= disk.first_config
    where = f"{KINDS[kind]}, {'power' if lost else 'kill'} before operation {number}, {disk.names[number]}"
    if certain and source.random() < 0.4:
        second, again = source.randrange(60), folder / "again"
        if not go_on(image, Disk(image, second, again, lost)):
            image, where = again, f"{where}, then before operation {second}"
    assert_goes_on(image, expected, certain, where)


def fill(source: random.Random, folder: Path, kind: int, disk: Disk, expected: Outcome) -> None:
    """Let the disk be full for a while. The training ends as ever, or says so and goes on later."""
    agent, options = KINDS[kind]
    first = source.randrange(disk.count)
    full = range(first, first + source.choice((1, 5, 1000)))
    assert_ends_or_says_so(folder / "run", agent, full, disk, expected, **options)
