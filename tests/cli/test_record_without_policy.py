"""`atari record` without a policy: its output, and a video with every played frame."""

import re
import sys
from pathlib import Path

import av
import numpy as np
import pytest
from cli_tools import Capture, Patch, record_json, refused
from env_tools import Observer
from video_reader import video_frames

import atari
from atari.cli import main
from atari.recording import RecordReplay
from atari.recording.video.writer import frame_rate


def test_writes_a_video_of_breakout_and_says_where(folder: Path, capsys: Capture) -> None:
    assert main(["record", "breakout", "--steps", "30"]) == 0
    captured = capsys.readouterr()
    path = folder / "videos" / "breakout-0.mp4"
    title = "breakout: Breakout, as 'breakout' with preset='dqn2015'\n"
    assert captured.out.startswith(f"{title}  policy  random, seed 0\n")
    assert captured.out.endswith(f"  file    {path.resolve()}\n")
    assert re.search(r"played  \d+ frames in [\d.]+ s, [\d,]+ frames/s, writing included", captured.out)
    assert re.search(r"27 of 30 steps, [\d,]+ steps/s", captured.err)
    with av.open(str(path)) as container:
        stream, sound = container.streams
        assert (stream.codec_context.name, sound.codec_context.name) == ("h264", "aac")
        assert (stream.width, stream.height) == (640, 420)
        assert stream.average_rate == frame_rate(atari.games["breakout"])


def test_video_has_every_emulated_frame_in_colour(capsys: Capture) -> None:
    result = record_json(capsys, "breakout", "--steps", "20", "--seed", "3", "-o", "a/b.mp4")
    assert result["files"] == [str(Path("a/b.mp4").resolve())]
    assert 20 * 4 < result["frames"] <= 20 * 4 + 30  # the no-ops at the start are played too
    shown = video_frames(Path("a/b.mp4"))
    assert len(shown) == result["frames"]
    red_row, blue_row = shown[-1][2 * 60, 4 * 80], shown[-1][2 * 90, 4 * 80]
    assert np.abs(red_row.astype(int) - (200, 72, 72)).max() < 16
    assert np.abs(blue_row.astype(int) - (66, 72, 200)).max() < 16


def test_a_pal_game_has_its_own_size_and_rate(capsys: Capture) -> None:
    result = record_json(capsys, "air_raid", "--steps", "5")
    with av.open(result["files"][0]) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height) == (640, 500)
        assert stream.average_rate == frame_rate(atari.games["air_raid"])
        assert stream.frames == result["frames"]


def test_the_same_seed_plays_the_same(capsys: Capture) -> None:
    facts = [record_json(capsys, "pong", "--steps", "150", "--no-video", "--seed", seed) for seed in "114"]
    assert facts[0]["files"] == []
    assert [facts[0][key] for key in ("frames", "scores")] == [facts[1][key] for key in ("frames", "scores")]
    assert facts[0]["frames"] != facts[2]["frames"]


def test_the_score_is_the_games_and_not_the_clipped_reward(capsys: Capture) -> None:
    (score,) = record_json(capsys, "ms_pacman", "--steps", "100", "--no-video")["scores"]
    assert score >= 50
    assert score % 10 == 0  # a dot is 10 points, and 1 after clipping


def test_games_are_counted_and_not_lives(capsys: Capture) -> None:
    result = record_json(capsys, "breakout", "--steps", "600", "--no-video")
    assert 2 <= len(result["scores"]) <= 5  # of five lives each


def test_seconds_are_those_of_the_console(capsys: Capture) -> None:
    assert 120 <= record_json(capsys, "pong", "--seconds", "2", "--no-video")["frames"] < 124
    assert 100 <= record_json(capsys, "air_raid", "--seconds", "2", "--no-video")["frames"] < 104


def test_no_video_makes_no_file(folder: Path, capsys: Capture) -> None:
    assert main(["record", "breakout", "--steps", "3", "--no-video"]) == 0
    assert "file" not in capsys.readouterr().out
    assert not list(folder.iterdir())


def test_observers_get_the_played_frames_and_none_after_the_end(folder: Path) -> None:
    env = atari.AtariEnv("breakout", core="ale", max_num_frames_per_episode=6)
    with RecordReplay(env, folder / "a.a26r") as recorded:
        observer = Observer(env, lambda *frame: "frame", lambda: "begun")
        recorded.reset(seed=0)
        assert env.driver.play_frames(1, frames=9) == 0
        assert env.core.truncated
    assert (observer.seen, recorded.recorder.frames) == (["begun", *["frame"] * 6], 6)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["breakout", "--no-video", "-o", "a.mp4"], "--no-video writes nothing; leave it or --output out"),
        (["breakuot"], "there is no game 'breakuot'; did you mean 'breakout'?"),
        (["combat"], "'combat' is a two-player cartridge"),
        (["breakout", "-o", "a.avi"], "ends in one of .mp4, .mkv, .webm, .gif, .png, .a26r, got 'a.avi'"),
        (["breakout", "-o", "occupied/a.mp4"], "occupied"),
        (["breakout", "-o", "folder.mp4"], "it is a folder, a device or a pipe; choose the name of a file: folder.mp4"),
    ],
)
def test_what_cannot_be_done_is_refused_before_playing(
    words: list[str], text: str, folder: Path, capsys: Capture, monkeypatch: Patch
) -> None:
    (folder / "occupied").touch()
    (folder / "folder.mp4").mkdir()
    monkeypatch.setattr("atari.cli.record._play", lambda *_: pytest.fail("it played"))
    refused(capsys, ["record", *words], text)
    assert sorted(path.name for path in folder.iterdir()) == ["folder.mp4", "occupied"]


def test_without_pyav_it_names_the_extra_and_the_way_without(folder: Path, monkeypatch: Patch, capsys: Capture) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    refused(capsys, ["record", "breakout", "--steps", "3"], "pip install 'av>=14'; or play without a video: --no-video")
    assert not list(folder.iterdir())
    for output in (["--no-video"], ["-o", "a.a26r"]):
        assert main(["record", "breakout", "--steps", "3", *output]) == 0
