"""`ReplayMemory.from_dataset`: a memory gives the observations that the agent got, to the bit."""

import gzip
import re
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from documents import page

import atari
from atari.lab import dataset_reader, write_dataset
from atari.lab.dataset_reader import StoredDataset, StoredEpisode
from atari.learning import ReplayMemory
from atari.learning.memory import replay_memory
from atari.recording import RecordReplay, Replay
from atari.task import Task

pytest.importorskip("h5py", reason="h5py is not installed")

PAGE = "recipes/offline-dqn.md"
STEPS = 150
TASKS: dict[str, dict[str, Any]] = {
    "whole games": {"preset": "dqn2015", "episodic_life": False},
    "lives": {"preset": "baselines"},
    "lives with one reset": {
        "preset": "envpool",
        "episodic_life": True,
        "on_reset": "continue",
        "seamless_lives": False,
    },
    "a limit": {"preset": "dopamine", "max_frames": 160},
    "RGB": {"preset": "dqn2015", "obs_type": "rgb", "stack_num": 2, "episodic_life": False},
    "RAM": {"obs_type": "ram"},
    "RAM stacks": {"obs_type": "ram", "stack_num": 3, "padding": "reset"},
    "single images": {"obs_type": "grayscale", "maxpool": True},
    "continuous actions": {"preset": "dopamine", "continuous": True},
}


def record(task: Task, path: Path) -> dict[int, dict[str, Any]]:
    """Record random play, and return its steps by their indices in a memory."""
    env = RecordReplay(atari.make(task), path)
    env.action_space.seed(0)
    before, _ = env.reset(seed=3)
    steps: dict[int, dict[str, Any]] = {}
    index, observations = 0, np.array(before)
    for number in range(STEPS):
        action = env.action_space.sample()
        after, reward, terminated, truncated, _ = env.step(action)
        over = env.unwrapped.core.game_over
        truncated = truncated or (number == STEPS - 1 and not terminated)
        steps[index] = {
            "observations": observations,
            "actions": np.array(action),
            "rewards": np.float32(reward),
            "next_observations": None if terminated and not over else np.array(after),
            "terminations": terminated,
            "truncations": truncated,
        }
        index += 1
        if terminated or truncated:
            index += 1
            after, _ = env.reset() if number < STEPS - 1 else (after, {})
        observations = np.array(after)
    env.close()
    return steps


def compare(memory: ReplayMemory, steps: dict[int, dict[str, Any]]) -> None:
    """Compare all steps: those of a batch of twenty times the memory's size."""
    assert len(memory) == len(steps)
    batch = memory.sample(20 * len(steps))
    assert set(batch.indices.tolist()) == set(steps)
    for row, index in enumerate(batch.indices.tolist()):
        for name, wanted in steps[index].items():
            if wanted is not None:
                assert np.array_equal(getattr(batch, name)[row], wanted), (index, name)


@pytest.mark.parametrize("name", TASKS)
def test_steps_are_those_of_the_environment(name: str, tmp_path: Path) -> None:
    steps = record(Task.of("breakout", **TASKS[name]), tmp_path / "a.a26r")
    write_dataset(tmp_path / "a.a26r", tmp_path / "a.h5", observations="seen", labels=[])
    compare(ReplayMemory.from_dataset(tmp_path / "a.h5", seed=0), steps)
    compare(ReplayMemory.from_dataset(tmp_path / "a.a26r", seed=0), steps)


@pytest.fixture
def lives(tmp_path: Path) -> tuple[Path, dict[int, dict[str, Any]]]:
    """A data set of games with several lives, and its steps."""
    steps = record(Task.of("breakout", preset="baselines"), tmp_path / "a.a26r")
    assert sum(step["next_observations"] is None for step in steps.values()) >= 2
    write_dataset(tmp_path / "a.a26r", tmp_path / "a.h5", observations="seen", labels=[])
    return tmp_path, steps


def test_formats(lives: tuple[Path, dict[int, dict[str, Any]]], monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
    pytest.importorskip("minari", reason="minari is not installed")
    path, steps = lives
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(path / "datasets"))
    (path / "parts").mkdir()
    for output in (path / "parts/a.parquet", "atari/breakout/random-v0"):
        write_dataset(path / "a.a26r", output, observations="seen", labels=[])
    replays = [Replay.load(path / "a.a26r")]
    for source in (path / "parts/a.parquet", path / "parts", "atari/breakout/random-v0", replays):
        compare(ReplayMemory.from_dataset(source, seed=0), steps)


def test_rewards_are_clipped_by_the_task_or_the_option(tmp_path: Path) -> None:
    record(Task.of("qbert", preset="dqn2015", reward_clipping=False, episodic_life=False), tmp_path / "a.a26r")
    paid = ReplayMemory.from_dataset(tmp_path / "a.a26r", seed=0).sample(1000).rewards
    clipped = ReplayMemory.from_dataset(tmp_path / "a.a26r", reward_clipping=True, seed=0).sample(1000).rewards
    assert set(paid.tolist()) == {0.0, 25.0}
    assert np.array_equal(clipped, np.minimum(paid, 1))


def test_steps_of_several_episodes_are_not_mixed(lives: tuple[Path, dict[int, dict[str, Any]]]) -> None:
    path, steps = lives
    batch = ReplayMemory.from_dataset(path / "a.h5", seed=0).sample(2000, n=3, gamma=0.5)
    for row, index in enumerate(batch.indices.tolist()):
        reward, discount = 0.0, 1.0
        for later in range(index, index + 3):
            reward, discount = reward + discount * steps[later]["rewards"], discount * 0.5
            if steps[later]["terminations"] or steps[later]["truncations"]:
                discount = 0.0 if steps[later]["terminations"] else discount
                break
        assert (batch.rewards[row], batch.discounts[row]) == (np.float32(reward), discount)


def test_one_episode_at_a_time_is_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    record(Task.of("breakout", **TASKS["a limit"]), tmp_path / "a.a26r")
    living: list[Any] = []

    class Watched(StoredEpisode):
        def __init__(self, *of: Any, **named: Any) -> None:
            assert not any(one() is not None for one in living)
            super().__init__(*of, **named)
            living.append(weakref.ref(self.frames))

    for ending in ("h5", "parquet"):
        if ending == "parquet":
            pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")
        write_dataset(tmp_path / "a.a26r", tmp_path / f"a.{ending}", observations="seen", labels=[])
        with monkeypatch.context() as patch:
            patch.setattr(dataset_reader, "StoredEpisode", Watched)
            ReplayMemory.from_dataset(tmp_path / f"a.{ending}")
    assert len(living) >= 4


def test_a_capacity_below_the_data_is_refused_before_frames_are_read(
    lives: tuple[Path, dict[int, dict[str, Any]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, steps = lives
    rows = max(steps) + 1
    assert ReplayMemory.from_dataset(path / "a.h5").capacity == rows

    def read(_: StoredDataset) -> Iterator[StoredEpisode]:
        raise AssertionError("episodes were read")

    monkeypatch.setattr(StoredDataset, "__iter__", read)
    with pytest.raises(ValueError, match=f"capacity={rows - 1} is too small: the data have {STEPS} steps.*{rows}"):
        ReplayMemory.from_dataset(path / "a.h5", capacity=rows - 1)
    with pytest.raises(TypeError, match="the task of the data decides stack_num"):
        ReplayMemory.from_dataset(path / "a.h5", stack_num=3)
    with pytest.raises(TypeError, match="reward_clipping"):
        ReplayMemory.from_dataset(path / "a.h5", reward_clipping=1)


def test_a_memory_goes_on_with_steps_of_an_environment(lives: tuple[Path, dict[int, dict[str, Any]]]) -> None:
    path, steps = lives
    memory = ReplayMemory.from_dataset(path / "a.h5", capacity=1000, seed=0)
    envs = atari.AtariVectorEnv(Task.of("breakout", preset="baselines").replace(stack_num=1), 1)
    memory.reset(envs.reset(seed=0)[0])
    _, *results = envs.step(np.ones(1, np.int64), out=memory.frames())
    memory.add(np.ones(1, np.int64), *results)
    assert len(memory) == STEPS + 1
    assert memory.sample(5000).indices.max() == max(steps) + 2


def test_a_file_is_complete_or_removed(lives: tuple[Path, dict[int, dict[str, Any]]]) -> None:
    path, steps = lives
    ReplayMemory.from_dataset(path / "a.h5", seed=0, path=path / "memory").close()
    with ReplayMemory.open(path / "memory") as memory:
        compare(memory, steps)


class Noise:
    """A data set of one episode whose frames cannot be compressed."""

    task = Task.of("breakout", preset="dopamine")

    def stacks(self) -> Iterator[Any]:
        yield np.eye(1, 801, dtype=np.uint8)[0]

    def __iter__(self) -> Iterator[StoredEpisode]:
        frames = np.random.default_rng(0).integers(0, 256, (801, 84, 84), np.uint8)
        zeros, no = np.zeros(800), np.zeros(800, bool)
        (stack,) = self.stacks()
        yield StoredEpisode(0, None, frames, stack, frames[:, 0, :1], zeros.astype(np.int64), zeros, no, no, zeros)


def test_compressed_frames_without_space_are_refused_and_the_file_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(replay_memory, "open_data", lambda source: source)
    assert len(ReplayMemory.from_dataset(Noise(), compressed_bytes=2**24)) == 800  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"compressed_bytes is too small: \d+ of 800 steps fit; give more"):
        ReplayMemory.from_dataset(Noise(), path=tmp_path / "memory", compressed_bytes=2**22)  # type: ignore[arg-type]
    assert not (tmp_path / "memory").exists()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"preset": "dopamine", "life_loss_info": True}, "life_loss_info"),
        ({"preset": "dopamine", "reward": "reward - lives_lost"}, "the agent was paid 'reward - lives_lost'"),
        ({"preset": "dopamine", "episodic_life": True, "on_reset": "new_game"}, "which games ended so"),
        ({"obs_type": "dict"}, "shows dicts"),
    ],
)
def test_tasks_that_a_memory_does_not_serve(options: dict[str, Any], match: str, tmp_path: Path) -> None:
    record(Task.of("breakout", **options), tmp_path / "a.a26r")
    with pytest.raises(ValueError, match=match):
        ReplayMemory.from_dataset(tmp_path / "a.a26r")


def test_other_sources(lives: tuple[Path, dict[int, dict[str, Any]]]) -> None:
    path, _ = lives
    write_dataset(path / "a.a26r", path / "screens.h5", labels=[])
    with pytest.raises(ValueError, match=r"not what the agent saw.*--observations seen"):
        ReplayMemory.from_dataset(path / "screens.h5")
    with pytest.raises(FileNotFoundError):
        ReplayMemory.from_dataset(path / "none.h5")


def test_dqn_replay(tmp_path: Path) -> None:
    """The program of the documentation reads Dopamine's layout."""
    (program,) = re.findall(r"^```python\n(import gzip.*?)^```$", "\n".join(page(PAGE)), re.MULTILINE | re.DOTALL)
    defined: dict[str, Any] = {}
    exec(program, defined)
    lengths, random = (5, 1, 7), np.random.default_rng(0)
    count = sum(3 + length for length in lengths)
    columns = {
        "observation": np.zeros((count, 84, 84), np.uint8),
        "action": np.zeros(count, np.int32),
        "reward": np.zeros(count, np.float32),
        "terminal": np.zeros(count, np.uint8),
    }
    row = 0
    for length in lengths:  # Dopamine puts three rows of zeros before each game
        game = slice(row + 3, row + 3 + length)
        columns["observation"][game] = random.integers(1, 256, (length, 84, 84))
        columns["action"][game], columns["reward"][game] = random.integers(0, 18, length), random.random(length)
        row = game.stop
        columns["terminal"][row - 1] = 1
    for name, column in columns.items():
        with gzip.open(tmp_path / f"$store$_{name}_ckpt.0.gz", "wb") as file:
            np.save(file, column)
    memory = defined["read_dqn_replay"](tmp_path, 0)
    rows = [row for row in range(count) if columns["observation"][row].any()]
    batch = memory.sample(1000)
    for steps, name in ((batch.actions, "action"), (batch.rewards, "reward"), (batch.terminations, "terminal")):
        found = dict(zip(batch.indices.tolist(), steps.tolist(), strict=True))
        assert [found[index] for index in sorted(found)] == columns[name][rows[:-1]].tolist()
    stacks = dict(zip(batch.indices.tolist(), batch.observations, strict=True))
    wanted = [columns["observation"][row - 3 : row + 1] for row in rows[:-1]]
    assert np.array_equal([stacks[index] for index in sorted(stacks)], wanted)
