"""`Freeze` and `Poke` while a replay is recorded: playing the replay gives the same bytes."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import atari
from atari.lab import Freeze, Poke, Ram
from atari.recording import RecordReplay, Replay

SCORE = 77


def rams_of(replay: Replay) -> list[bytes]:
    """The RAM after each frame."""
    return [frame.ram.tobytes() for frame in replay.frames()]


def play(env: Any, steps: int) -> list[bytes]:
    """Play steps of one frame at random."""
    rams = []
    for _ in range(steps):
        _, _, terminated, truncated, _ = env.step(env.action_space.sample())
        rams.append(env.unwrapped.core.ram().tobytes())
        assert not terminated
        assert not truncated
    return rams


def environment(path: Path, **options: Any) -> RecordReplay:
    env = RecordReplay(atari.AtariEnv("breakout", frameskip=1, **options), path)
    env.action_space.seed(0)
    return env


def test_all_kinds_of_writes(tmp_path: Path) -> None:
    env = environment(tmp_path / "a.a26r", interventions=["infinite_lives"])
    env.reset(seed=0)
    rams = play(env, 20)
    with Freeze(env, {99: 9, 98: "old + random(0, 2)"}), Freeze(env, player_x=80):
        rams += play(env, 30)
        Poke(env, {"lives": 3}, when="frame > 60")
        rams += play(env, 30)
    Poke(env, {SCORE: 5}, paid=False)
    Ram(env)["player_x"] = 100
    rams += play(env, 30)
    env.close()
    replay = Replay.load(tmp_path / "a.a26r")
    assert rams_of(replay) == rams
    assert replay.verify("native")
    assert replay.verify("plain")
    with pytest.raises(ValueError, match="core"):
        replay.verify("ale")


def test_two_of_a_byte_end_in_any_order(tmp_path: Path) -> None:
    env = environment(tmp_path / "a.a26r")
    env.reset(seed=0)
    first, second, third = Freeze(env, {99: 1}), Freeze(env, {99: 1}), Freeze(env, {99: "old"})
    rams = play(env, 5)
    first.release()
    rams += play(env, 5)
    fourth = Freeze(env, {99: 7})  # in the slot of the first, so the others write later
    rams += play(env, 5)
    for freeze in (third, second, fourth):
        freeze.release()
        rams += play(env, 5)
    env.close()
    assert rams_of(Replay.load(tmp_path / "a.a26r")) == rams


def test_snapshots_and_later_passes(tmp_path: Path) -> None:
    env = environment(tmp_path / "a.a26r", interventions=["infinite_lives"])
    env.reset(seed=0)
    Poke(env, {98: 2}, frame=300)
    rams = play(env, 299)
    before = env.snapshot()
    with Freeze(env, {99: 9}):
        rams += play(env, 301)
        env.restore(before)
        rams += play(env, 700)
    env.close()
    replay = Replay.load(tmp_path / "a.a26r")
    assert rams_of(replay) == rams
    for start in (250, 590, 1000):  # from checkpoints
        assert [frame.ram.tobytes() for frame in replay.frames(start, start + 50)] == rams[start : start + 50]
        assert replay.seek(start).ram().tobytes() == rams[start - 1]


def test_writes_made_before_the_recording(tmp_path: Path) -> None:
    env = atari.AtariEnv("breakout", frameskip=1)
    env.reset(seed=0)
    Poke(env, {98: 2}, frame=2)
    ended, held = Freeze(env, {98: 1}), Freeze(env, {99: 9})
    ended.release()
    for _ in range(5):
        env.step(0)
    recorded = RecordReplay(env, tmp_path / "a.a26r")
    recorded.action_space.seed(0)
    rams = play(recorded, 10)
    recorded.env.unwrapped.driver.make_sound()  # type: ignore[attr-defined]
    held.release()
    rams += play(recorded, 10)
    again = Freeze(recorded, {99: 3})
    rams += play(recorded, 10)
    recorded.stop()
    again.release()
    assert not [write for write in env.core.writes if write][1:]  # only the poke
    assert rams_of(Replay.load(tmp_path / "a.a26r")) == rams


@pytest.mark.parametrize("options", [{}, {"preset": "dqn2015"}, {"autoreset_mode": "Disabled"}])
def test_a_vector(options: dict[str, Any], tmp_path: Path) -> None:
    envs: Any = atari.AtariVectorEnv("breakout", 3, num_threads=1, **options)
    envs = RecordReplay(envs, tmp_path / "a.a26r", index=1)
    envs.reset(seed=3)
    generator = np.random.default_rng(0)
    rams = []

    def steps(count: int) -> None:
        for _ in range(count):
            envs.step(generator.integers(0, 4, 3))
            rams.append(envs.unwrapped.lanes[1].ram().tobytes())

    steps(10)
    with Freeze(envs, {99: np.array([1, 2, 3])}), Freeze(envs, {99: 200}, index=0):
        steps(30)
        Poke(envs, {98: 5}, when="frame > 60")
        steps(100)
    Ram(envs)["player_x"] = np.array([70, 80, 90])
    steps(20)
    envs.close()
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify("native")
    played = iter(rams_of(replay))
    assert all(ram in played for ram, _ in itertools.groupby(rams))  # in this order


def test_a_vector_with_writes_already(tmp_path: Path) -> None:
    envs = atari.AtariVectorEnv("breakout", 2)
    freeze = Freeze(envs, {99: 1}, index=1)
    with pytest.raises(ValueError, match="release it, and make it after RecordReplay"):
        RecordReplay(envs, tmp_path / "a.a26r", index=1)
    freeze.release()
    RecordReplay(envs, tmp_path / "a.a26r", index=1).close()


def test_writes_that_are_refused_are_not_recorded(tmp_path: Path) -> None:
    env = environment(tmp_path / "a.a26r")
    env.reset(seed=0)
    core: Any = env.unwrapped.core
    with Freeze(env, {SCORE: 5}):
        with pytest.raises(ValueError, match="at most"):
            core.writes = core.writes * 1000
        rams = play(env, 60)
    env.close()
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.verify()
    assert rams_of(replay)[-60:] == rams
