"""How recordings end: complete, cut, killed, on a full disk, stopped, and without close."""

import copy
import gc
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from replay_tools import full_disk, play, record

import atari
from atari.recording import RecordReplay, Replay

KILLED = """if True:
    import os, sys
    import atari
    from atari.recording import RecordReplay
    env = RecordReplay(atari.AtariEnv("breakout"), sys.argv[1])
    env.reset(seed=3)
    for step in range(1000):
        if env.step(step % 4)[2]:
            env.reset()
    os.kill(os.getpid(), 9)
"""


def test_a_killed_recording_leaves_all_but_the_last_seconds(tmp_path: Path) -> None:
    path = tmp_path / "a.a26r"
    result = subprocess.run([sys.executable, "-c", KILLED, str(path)], cwd=tmp_path, timeout=120, check=False)
    assert result.returncode == -signal.SIGKILL
    with pytest.warns(UserWarning, match=r"a\.a26r was cut while it was recorded; its first [\d,]+ frames are whole"):
        replay = Replay.load(path)
    assert not replay.complete
    assert 3700 < replay.frames_total <= 4000
    assert replay.verify("ale").frames == replay.frames_total
    assert sum(episode.frames for episode in replay.episodes) == replay.frames_total


def test_a_cut_file_plays_up_to_the_cut(tmp_path: Path) -> None:
    path = record(tmp_path / "a.a26r", "pong", 900)
    whole = [frame.ram for frame in Replay.load(path).frames()]
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.warns(UserWarning, match="was cut"):
        replay = Replay.load(path)
    assert replay.verify()
    part = [frame.ram for frame in replay.frames()]
    assert 240 <= len(part) < len(whole)
    assert np.array_equal(part, whole[: len(part)])


def test_a_full_disk_is_a_deferred_error_once_and_the_game_continues(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("breakout"), tmp_path / "a.a26r")
    env.reset(seed=3)
    errors = []
    with full_disk(900):
        for step in range(400):
            try:
                over = env.step(step % 4)[2]
            except OSError as error:
                errors.append((error.strerror, error.filename))
                over = env.step(step % 4)[2]
            if over:
                env.reset()
        env.close()
    assert errors == [("File too large; the replay ends before this, the game goes on", str(env.path))]
    with pytest.warns(UserWarning, match="was cut"):
        replay = Replay.load(env.path)
    assert replay.frames_total >= 240
    assert replay.verify()


def test_stopping_lets_the_game_go_on(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("pong"), tmp_path / "a.a26r")
    play(env, 10)
    env.stop()
    size = env.path.stat().st_size
    play(env, 500)
    copy.deepcopy(env.env)
    assert env.path.stat().st_size == size
    assert Replay.load(env.path).frames_total == 40
    again = RecordReplay(env.env, tmp_path / "b.a26r")
    again.close()


def test_a_recording_is_completed_without_close(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("pong"), tmp_path / "a.a26r")
    play(env, 10)
    del env
    gc.collect()
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.complete
    assert replay.frames_total == 40
    assert repr(replay) == f"Replay({str(tmp_path / 'a.a26r')!r}, pong, 40 frames)"


def test_a_reset_with_a_seed_keeps_the_summary_of_the_episode_before(tmp_path: Path) -> None:
    env = RecordReplay(atari.AtariEnv("pong", frameskip=1), tmp_path / "a.a26r")
    for seed, steps in ((1, 300), (2, 200)):
        env.reset(seed=seed)
        for _ in range(steps):
            env.step(0)
    env.close()
    assert [episode.frames for episode in Replay.load(tmp_path / "a.a26r").episodes] == [300, 200]


def test_an_environment_that_is_closed_inside_completes_the_file(tmp_path: Path) -> None:
    env = atari.AtariEnv("breakout")
    with RecordReplay(env, tmp_path / "a.a26r") as recorded:
        recorded.reset(seed=0)
        recorded.step(1)
        env.close()
    replay = Replay.load(tmp_path / "a.a26r")
    assert replay.complete
    assert replay.verify()
    assert [episode.end for episode in replay.episodes] == ["open"]
