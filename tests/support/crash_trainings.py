"""Tiny trainings that are stopped at a durable operation, and go on."""

import warnings
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
import torch
from crash_model import Disk, FullDisk, Stopped, on
from small_trainings import make_options

from atari.learning.agents import dqn
from atari.learning.run_folder import RunFolder
from atari.learning.training import Training

TINY: dict[str, dict[str, Any]] = {
    "ppo": {"total_steps": 256},
    "pqn": {"total_steps": 256},
    "dqn": {"total_steps": 400, "memory": 200, "learning_starts": 100, "train_every": 100},
}
"""Options by agent, for trainings of five checkpoints."""

Outcome = tuple[dict[str, Any], str]


@contextmanager
def small_updates() -> Iterator[None]:
    """Let an update of DQN, after which there can be a checkpoint, have 80 steps."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dqn, "_UPDATE", 80)
        yield


def train(agent: str, path: Path, disk: Disk, **given: Any) -> bool:
    """Train until the end, or until the disk stops the training; returns whether it has ended."""
    options = make_options(agent, "breakout", **{"checkpoint_minutes": 0.0, **TINY[agent], **given})
    try:
        with small_updates(), on(disk), closing(Training.begin(agent, options, path)) as training:
            training.run()
    except Stopped:
        return False
    return True


def go_on(path: Path, disk: Disk | None = None) -> bool:
    """Resume until the end, as a user would; or until the disk stops the training."""
    try:
        with warnings.catch_warnings(), small_updates(), on(disk or Disk(path, -1)):
            warnings.simplefilter("ignore")  # damaged rows of the log
            with RunFolder.open(path, lock=True) as folder:
                if folder.config.get("ended"):
                    return True
            with closing(Training.resume(path)) as training:
                training.run()
    except Stopped:
        return False
    return True


def outcome(path: Path) -> Outcome:
    """The weights and the log, but for its times."""
    folder = RunFolder.open(path)
    return folder.load_weights(), str([{**row, "seconds": 0} for row in folder.rows()])


def assert_goes_on(image: Path, expected: Outcome, has_config: bool, where: str) -> None:
    """The training in an image ends as expected. Without its configuration it must be called anew."""
    if not has_config and not (image / "config.json").exists():
        return
    assert go_on(image), where
    weights, rows = outcome(image)
    assert all(torch.equal(weights[name], value) for name, value in expected[0].items()), where
    assert rows == expected[1], where


def assert_ends_or_says_so(path: Path, agent: str, full: range, disk: Disk, expected: Outcome, **options: Any) -> None:
    """A training whose disk has no room for some operations ends as ever, or raises an `OSError` and goes on later."""
    where = f"{agent} {options}, full at {full}"
    try:
        assert train(agent, path, FullDisk(path, full), **options)
    except OSError:
        certain = disk.first_config is not None and full.start >= disk.first_config
        assert_goes_on(path, expected, certain, where)
        return
    weights, _ = outcome(path)
    assert all(weights[name].equal(value) for name, value in expected[0].items()), where
