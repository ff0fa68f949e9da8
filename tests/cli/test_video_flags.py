"""`--speed`, `--frame` and the other looks of videos and pictures, in each command that writes them."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from cli_tools import Capture, read, refused
from replay_tools import record
from video_reader import NTSC, frame_times

from atari.cli import main
from atari.recording import Replay


def test_the_best_frame_and_part_are_named(capsys: Capture) -> None:
    record(Path("b.a26r"), "breakout", 200)
    rewards = [frame.reward for frame in Replay.load("b.a26r").frames()]
    best = rewards.index(max(rewards))
    assert read(capsys, "replay", "render", "b.a26r", "-o", "a.png", "--frame", "best").startswith(f"frame {best} in ")
    assert main(["replay", "render", "b.a26r", "-o", "a.gif", "--start", "best", "--seconds", "0.5"]) == 0
    start = Replay.load("b.a26r").best_start(30)
    assert capsys.readouterr().out.startswith(f"30 frames of the game, from frame {start} on, in ")
    assert main(["replay", "render", "b.a26r", "-o", "a.jpg", "--frame", "3"]) == 1
    assert ".mp4" in capsys.readouterr().err  # the endings that there are


@pytest.mark.parametrize("words", [["record", "breakout", "--seconds", "1"], ["replay", "render", "b.a26r"]])
def test_slow_motion_and_a_picture(words: list[str], capsys: Capture) -> None:
    if words[0] == "replay":
        record(Path("b.a26r"), "breakout", 12)
        assert main([*words, "-o", "a.mkv", "--speed", "0.25", "--scale", "1"]) == 0
        assert read(capsys, *words, "-o", "a.png", "--frame", "20", "--scale", "1").endswith(
            f"frame 20 in {Path('a.png').resolve()}\n"
        )
    else:
        outputs = ["-o", "a.mkv", "-o", "a.png", "-o", "b.a26r", "-o", "%03d.png"]
        assert main([*words, *outputs, "--speed", "0.25", "--frame", "20", "--scale", "1"]) == 0
    replay = Replay.load("b.a26r")
    assert frame_times(Path("a.mkv")) == pytest.approx([4 * i / NTSC for i in range(replay.frames_total)], abs=0.0011)
    (shown,) = replay.frames(20, 21)
    assert np.array_equal(cv2.imread("a.png")[..., ::-1], shown.screen.repeat(2, axis=1))


def test_the_picture_of_a_video_without_a_choice_is_its_last_frame() -> None:
    assert main(["record", "breakout", "--episodes", "2", "--best", "-o", "a.png", "-o", "b.a26r", "--scale", "1"]) == 0
    replay = Replay.load("b.a26r")
    *_, last = (frame for frame in replay.frames() if frame.episode == replay.best_episode)
    assert np.array_equal(cv2.imread("a.png")[..., ::-1], last.screen.repeat(2, axis=1))
    assert main(["record", "breakout", "--policy", "b.a26r", "--frame", "best", "-o", "c.png"]) == 0
    assert Path("c.png").exists()


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["-o", "a.a26r", "--speed", "2"], "--speed is for a video, and the command writes a.a26r; leave it out"),
        (["-o", "a.png", "-o", "%03d.png", "--speed", "2"], "--speed is for a video, and the command writes a.png, "),
        (["-o", "a.mp4", "--frame", "3"], "is for a picture, such as -o game.png, and the command writes a.mp4"),
        (["-o", "%03d.png", "--frame", "best"], "--frame is for a picture"),
        (["--frame", "0"], "--frame is for a picture, such as -o game.png, and the command writes videos/pong-0.mp4"),
        (["-o", "a.a26r", "--scale", "2"], "--scale is for a video or a picture, and the command writes a.a26r"),
        (["-o", "a.a26r", "--overlay", "ram"], "--overlay is for a video or a picture"),
        (["-o", "a.gif", "-o", "a.png", "--no-sound"], "--no-sound is for a video with sound, and"),
        (["-o", "a.a26r", "--best"], "--best is for videos and pictures, and a replay has all games; leave it out"),
        (["-o", "a.png", "--frame", "3", "--best"], "3 is a frame of all games; leave --best and --seconds out"),
    ],
)
def test_options_without_effect(words: list[str], text: str, capsys: Capture) -> None:
    refused(capsys, ["record", "pong", *words], text)
    assert not list(Path().iterdir())


def test_options_without_effect_in_other_commands(capsys: Capture) -> None:
    record(Path("a.a26r"), "pong", 3)
    for words, text in (
        (["record", "pong", "--no-video", "--speed", "2"], "--speed is for a video, and the command writes nothing"),
        (["replay", "render", "a.a26r", "--frame", "1"], "--frame is for a picture, such as -o game.png, and "),
        (["replay", "render", "a.a26r", "-o", "a.png", "--speed", "2"], "--speed is for a video"),
        (["replay", "render", "a.a26r", "-o", "a.gif", "--no-sound"], "--no-sound is for a video with sound"),
        (["replay", "render", "a.a26r", "-o", "a.png", "--frame", "3", "--stop", "5"], "leave episode, start and stop"),
        (["record", "pong", "--policy", "a.a26r", "-o", "a.png", "--frame", "3", "--seconds", "1"], "--seconds out"),
    ):
        refused(capsys, words, text)
    refused(capsys, ["record", "pong", "--speed", "17"], "--speed: '17' is not a number within 0.05..16", 2)
    assert [path.name for path in Path().iterdir()] == ["a.a26r"]
