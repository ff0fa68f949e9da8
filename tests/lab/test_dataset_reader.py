"""`read_dataset`: the stacks of a data set are those that the agent got, in all formats; old files open."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.lab import read_dataset, write_dataset
from atari.policy.choice import Choice
from atari.recording import RecordReplay
from atari.task import Task

h5py = pytest.importorskip("h5py", reason="h5py is not installed")

STEPS = 120
TASKS: dict[str, dict[str, Any]] = {
    "images": {"preset": "dopamine", "episodic_life": True},
    "a new stack after lives": {"preset": "baselines"},
    "a stack over lives": {"preset": "envpool", "episodic_life": True},
    "RGB": {"preset": "dqn2015", "obs_type": "rgb", "stack_num": 2},
    "RAM": {"obs_type": "ram"},
    "RAM stacks": {"obs_type": "ram", "stack_num": 3, "padding": "reset"},
    "single images": {"obs_type": "grayscale", "maxpool": True},
    "screens": {},
}


def played(task: Task, path: Path) -> list[np.ndarray[Any, Any]]:
    """Record random play, and return the observation in which each action was chosen, and the last one."""
    env = RecordReplay(atari.make(task), path)
    env.action_space.seed(0)
    seen, _ = env.reset(seed=3)
    found = []
    for _ in range(STEPS):
        found.append(np.array(seen))
        seen, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            seen, _ = env.reset()
    env.close()
    return [*found, np.array(seen)]


@pytest.mark.parametrize("name", TASKS)
def test_observations(name: str, tmp_path: Path) -> None:
    task = Task.of("breakout", **TASKS[name])
    expected = played(task, tmp_path / "a.a26r")
    write_dataset(tmp_path / "a.a26r", tmp_path / "a.h5", observations="seen", labels=[])
    dataset = read_dataset(tmp_path / "a.h5")
    assert dataset.task == task
    got = [observation for episode in dataset for observation in episode.observations()[: len(episode)]]
    assert np.array_equal(got, expected[:STEPS])
    (last,) = [*dataset][-1].observations()[-1:]
    assert np.array_equal(last, expected[-1])
    assert np.array_equal(next(iter(dataset)).observations(5, 9), got[5:9])
    assert all(np.array_equal(*pair) for pair in zip(dataset.stacks(), [one.stack for one in dataset], strict=True))


def test_each_frame_is_stored_once(tmp_path: Path) -> None:
    task = Task.of("breakout", preset="baselines")
    played(task, tmp_path / "a.a26r")
    write_dataset(tmp_path / "a.a26r", tmp_path / "a.h5", observations="seen", labels=[])
    (episode,) = read_dataset(tmp_path / "a.h5")
    assert episode.frames is not None
    assert episode.stack is not None
    assert episode.frames.shape == (STEPS + 1, 84, 84)
    assert episode.stack[0] == 1
    assert 2 <= (episode.stack == 1).sum() <= 6


def same(one: Any, other: Any) -> bool:
    names = ("frames", "stack", "ram", "actions", "rewards", "terminations", "truncations", "chosen")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)


@pytest.mark.parametrize("observations", ["seen", "screen", "grayscale", "ram"])
def test_the_formats_are_equal(observations: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    pytest.importorskip("minari", reason="minari is not installed")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "datasets"))
    played(Task.of("breakout", preset="dopamine"), tmp_path / "a.a26r")

    def chosen(episode: int, steps: int) -> Any:
        return np.arange(steps, dtype=np.uint8) % len(Choice)

    for output in (tmp_path / "a.h5", tmp_path / "a.parquet", "breakout/seen-v0"):
        write_dataset(tmp_path / "a.a26r", output, observations=observations, labels=["ball_x"], chosen=chosen)
    (first,) = read_dataset(tmp_path / "a.h5")
    assert first.chosen.tolist() == chosen(0, STEPS).tolist()
    assert (first.frames is None) == (observations == "ram")
    for source in (tmp_path / "a.parquet", "breakout/seen-v0"):
        (episode,) = read_dataset(source)
        assert same(episode, first)


def test_ram_of_agents_in_parquet(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    expected = played(Task.of("breakout", obs_type="ram"), tmp_path / "a.a26r")
    write_dataset(tmp_path / "a.a26r", tmp_path / "a.parquet", observations="seen", labels=[])
    (episode,) = read_dataset(tmp_path / "a.parquet")
    assert np.array_equal(episode.observations(), expected)


GOLDEN = sorted((Path(__file__).parent / "data").glob("seen_1.*"))
"""Files of version 1: ten steps of Pong by preset "atari100k" with images of 10x12, whose last actions were drawn."""


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.suffix)
def test_files_of_version_1(path: Path) -> None:
    pytest.importorskip({".h5": "h5py", ".parquet": "pyarrow.parquet"}[path.suffix])
    dataset = read_dataset(path)
    assert dataset.task == Task.of("pong", preset="atari100k", img_height=10, img_width=12)
    assert (dataset.facts["policy"], dataset.facts["observations"]["version"]) == ("golden", 1)
    (episode,) = dataset
    assert (len(episode), episode.seed, episode.frames is not None) == (10, 7, True)
    assert episode.observations().shape == (11, 4, 10, 12)
    assert int(episode.observations().sum()) == 483_360
    assert episode.actions.tolist() == [0, 1, 2, 3, 4, 5, 0, 1, 2, 3]
    assert episode.chosen.tolist() == [1] * 8 + [3] * 2


def test_there_are_golden_files() -> None:
    assert {path.suffix for path in GOLDEN} == {".h5", ".parquet"}


def test_what_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="there is no data set"):
        read_dataset(tmp_path / "a.h5")
    with h5py.File(tmp_path / "other.h5", "w") as root:
        root.attrs["task"] = "{}"
    with pytest.raises(ValueError, match="has data of version None, not 1"):
        read_dataset(tmp_path / "other.h5")
    with h5py.File(tmp_path / "later.h5", "w") as root:
        root.attrs.update({"task": "{}", "observations": '{"version": 2}'})
    with pytest.raises(ValueError, match="has data of version 2, not 1"):
        read_dataset(tmp_path / "later.h5")
