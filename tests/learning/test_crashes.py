"""A training that is killed, or loses power, at any durable operation goes on and ends as one that was not."""

import random
from pathlib import Path
from typing import Any

import pytest

torch = pytest.importorskip("torch")

from crash_model import Disk, FullDisk  # noqa: E402
from crash_trainings import TINY, Outcome, assert_ends_or_says_so, assert_goes_on, outcome, train  # noqa: E402

IMAGES = 8
"""Images of each agent and kind; the attacker `crashes` makes as many as its time allows."""


class Album(Disk):
    """The disk of a training that goes on, with an image before each of some operations, as if it had stopped there."""

    def __init__(self, folder: Path, images: dict[int, Path], generator: random.Random | None) -> None:
        super().__init__(folder, stop_at=-1, generator=generator)
        self.images = images

    def before(self, name: str, arguments: tuple[Any, ...]) -> None:
        if self.count in self.images:
            self._make_image(self.images[self.count])
        super().before(name, arguments)


@pytest.fixture(scope="module", params=TINY)
def whole(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Disk, Outcome]:
    """An agent, the disk of its whole training, and the training's outcome."""
    path = tmp_path_factory.mktemp("whole") / "run"
    disk = Disk(path, stop_at=-1)
    assert train(request.param, path, disk)
    assert not (path / "memory.replay").exists()
    return request.param, disk, outcome(path)


@pytest.mark.parametrize("power", [False, True], ids=["kill", "power"])
def test_a_crash_loses_nothing(whole: tuple[str, Disk, Outcome], tmp_path: Path, power: bool) -> None:
    agent, disk, expected = whole
    needed = {"write", "sync", "replace", "sync_folder"} | ({"sync_map"} if agent == "dqn" else set())
    assert needed <= set(disk.names)
    generator = random.Random(f"{agent} {power}")
    images = {number: tmp_path / f"image-{number}" for number in generator.sample(range(disk.count), IMAGES)}
    assert train(agent, tmp_path / "run", Album(tmp_path / "run", images, generator if power else None))
    assert all(image.is_dir() for image in images.values())
    for number, image in sorted(images.items()):
        has_config = disk.first_config is not None and number >= disk.first_config
        assert_goes_on(image, expected, has_config, f"{agent} before operation {number}, {disk.names[number]}")


@pytest.mark.filterwarnings("ignore:no checkpoint at step:RuntimeWarning", "ignore:the log is kept:RuntimeWarning")
def test_a_full_disk_ends_a_training_with_a_reason(whole: tuple[str, Disk, Outcome], tmp_path: Path) -> None:
    agent, disk, expected = whole
    for first in range(0, disk.count, max(1, disk.count // 4)):
        full = range(first, first + 1000)
        assert_ends_or_says_so(tmp_path / f"run-{first}", agent, full, disk, expected)


@pytest.mark.filterwarnings("ignore:no checkpoint at step:RuntimeWarning", "ignore:the log is kept:RuntimeWarning")
def test_a_checkpoint_that_fails_may_be_one_that_the_memory_needs(tmp_path: Path) -> None:
    options = {"compress": True, "num_envs": 8}
    with pytest.raises(OSError, match="the replay memory needs a checkpoint at step"):
        train("dqn", tmp_path / "run", FullDisk(tmp_path / "run", range(26, 1026)), **options)
