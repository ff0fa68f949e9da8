"""Files of frontiers: what is read equals what was written, also for a training's task; damage and forgery."""

import zlib
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.cores.snapshot import pack, unpack
from atari.learning import load_policy
from atari.learning.diagnosis.diagnosis import frontier_of
from atari.learning.diagnosis.moments import Moment
from atari.learning.diagnosis.plays import play_games
from atari.learning.frontier import MOST, read_frontier, write_frontier

TASK = atari.Task.of("breakout", preset="envpool", stack_num=2, img_height=42, img_width=42)
TRAINING = TASK.replace(episodic_life=True, repeat_action_probability=0.0, reward_clipping=False, noops=(0, 0))


def played(task: atari.Task, lanes: int = 3, steps: int = 40) -> atari.AtariVectorEnv:
    envs = atari.AtariVectorEnv(task, lanes)
    envs.reset(seed=1)
    rng = np.random.default_rng(0)
    for _ in range(steps):
        envs.step(rng.integers(4, size=lanes))
    return envs


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "breakout.frontier"
    with closing(played(TASK)) as envs:
        write_frontier(path, TASK, envs.snapshot(), [1, 2.5, 3])
    return path


def observed(task: atari.Task, snapshots: Any, steps: int = 0) -> tuple[bytes, ...]:
    """The observation and RAM of environments that go on from snapshots."""
    with closing(atari.AtariVectorEnv(task, len(snapshots), repeat_action_probability=0.0)) as envs:
        envs.reset(seed=0)
        envs.restore(None, [one._replace(task=envs.snapshot([0])[0].task) for one in snapshots])
        for _ in range(steps):
            envs.step(np.full(len(snapshots), 2))
        return envs.observe()[0].tobytes(), envs.ram().tobytes()


@pytest.mark.parametrize("task", [TASK, TRAINING])
def test_what_is_read_is_what_was_written(file: Path, task: atari.Task) -> None:
    """The states of one task, read for another one, show and play the same."""
    read = read_frontier(file, task)
    assert read.scores == (1, 2.5, 3)
    with closing(played(TASK)) as envs:
        expected = envs.snapshot()
    assert observed(task, read.snapshots) == observed(TASK, expected)
    assert observed(task, read.snapshots, 6) == observed(TASK, expected, 6)  # no life is lost
    with closing(atari.AtariVectorEnv(task, 3)) as envs:
        envs.reset(seed=0)
        envs.restore(None, read.snapshots)


def test_a_file_is_made_of_its_content_alone(file: Path) -> None:
    again = file.with_name("again")
    read = read_frontier(file, TASK)
    write_frontier(again, TASK, read.snapshots, read.scores)
    assert again.read_bytes() == file.read_bytes()


@pytest.mark.parametrize(
    ("task", "text"),
    [
        (atari.Task.of("pong", preset="envpool", stack_num=2, img_height=42, img_width=42), "game = 'breakout'"),
        (TASK.replace(stack_num=4), "stack_num = 2, but this environment has 4"),
        (TASK.replace(img_height=84), "img_height = 42, but this environment has 84"),
        (TASK.replace(mode=4), "mode = 0, but this environment has 4"),
    ],
)
def test_another_game_or_observation_is_refused(file: Path, task: atari.Task, text: str) -> None:
    with pytest.raises(ValueError, match=f"cannot be used by this task: .*{text}"):
        read_frontier(file, task)


def test_bad_arguments_write_nothing(tmp_path: Path) -> None:
    path = tmp_path / "one"
    with closing(played(TASK, 1, 1)) as envs:
        (one,) = envs.snapshot()
    other = TASK.replace(stack_num=4)
    bad: list[tuple[Any, Any, Any, str]] = [
        (TASK, [], [], f"1 to {MOST} snapshots, got 0"),
        (TASK, [one], [], "a finite number for each of 1 snapshots"),
        (TASK, [one], [float("nan")], "a finite number for each of 1 snapshots"),
        (other, [one], [0], "stack_num = 2, but"),
        (TASK, [one.state], [0], "must be those of AtariVectorEnv.snapshot"),
    ]
    for task, snapshots, scores, text in bad:
        with pytest.raises((TypeError, ValueError), match=text):
            write_frontier(path, task, snapshots, scores)
    assert not path.exists()


def test_forged_and_damaged_files_are_refused(file: Path) -> None:
    good = file.read_bytes()
    facts, blobs = unpack(good)
    state = zlib.decompress(blobs["0"])
    bomb = zlib.compress(bytes(1 << 26))
    forged: list[tuple[bytes, str]] = [
        (b"", "is no frontier, or damaged: the snapshot is empty"),
        (good[:-1], "is no frontier, or damaged"),
        (pack({**facts, "of": "play"}, blobs), "is no frontier; `atari diagnose`"),
        (pack(facts, {}), "is no frontier; `atari diagnose`"),
        (pack({**facts, "state version": 0}, blobs), "has states of version 0, and this release of atari-envs reads"),
        (pack({**facts, "scores": [1, 2]}, blobs), "not one score for each"),
        (pack({**facts, "scores": [1, 2, "3"]}, blobs), "not one score for each"),
        (pack({**facts, "task": None}, blobs), "its task is None"),
        (pack({**facts, "image": 3}, blobs), "another ROM image"),
        (pack(facts, {**blobs, "1": bomb}), "a state in it is damaged"),
        (pack(facts, {**blobs, "1": b"no zlib"}), "a state in it is damaged"),
        (pack(facts, {**blobs, "1": zlib.compress(state[:-1])}), "a state in it is damaged"),
        (pack(facts, {**blobs, "1": zlib.compress(b"\xff" * len(state))}), "a state in it is damaged"),
        (pack(facts, {"zero": blobs["0"], "1": blobs["1"], "2": blobs["2"]}), "a state in it is damaged"),
    ]
    for data, text in forged:
        file.write_bytes(data)
        with pytest.raises(ValueError, match=text):
            read_frontier(file, TASK)
    with pytest.raises(FileNotFoundError):
        read_frontier(file.with_name("missing"), TASK)


def test_the_states_before_moments(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each state is that of the game, also before its first step and beside a lost life that waits for a reset."""
    task = TRAINING.replace(on_reset="continue", max_num_frames_per_episode=2000)
    plays = play_games(load_policy("random"), task, 2, seed=0)
    reset = plays[0].resets[0]
    moments = [Moment(0, reset + 5, "life"), Moment(1, 12, "life"), Moment(1, 13, "life")]
    found = frontier_of(plays, moments, before=[5, 12])
    steps = [(0, reset - 1), (0, reset - 7), (1, 7), (1, 0), (1, 8), (1, 1)]
    with closing(plays.player.make(len(steps))) as envs:
        envs.reset(seed=0)
        envs.restore(None, found.snapshots)
        expected = np.stack([plays[play].rams[step] for play, step in steps])
        np.testing.assert_array_equal(envs.ram(), expected)
        assert not any(lane.ended for lane in envs.lanes)
    assert found.scores == tuple(plays[play].totals[step] for play, step in steps)
    assert frontier_of(plays, moments[:1], before=[10**6]).scores == (0,)
    monkeypatch.setattr("atari.learning.diagnosis.diagnosis.MOST", 2)
    assert frontier_of(plays, moments, before=[5, 12]).scores == (found.scores[0], found.scores[-1])
