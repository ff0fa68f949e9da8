"""Slow and fast videos: the times of their frames and of their sound, at every place that makes a video."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from replay_tools import record
from video_reader import NTSC, PAL, frame_times, sound, video_frames

import atari
from atari.recording import RecordVideo, Replay, VideoWriter
from atari.recording.video.audio import to_16_bit

PONG = atari.games["pong"]
SCREEN = np.zeros((210, 160, 3), np.uint8)
TONE = np.tile(np.repeat(np.array([128, 188], np.uint8), 16), 16)


def tones(path: Path, speed: float, frames: int) -> Path:
    with VideoWriter(path, PONG, speed=speed, scale=1, sound=True) as video:
        for _ in range(frames):
            video.write(SCREEN, TONE)  # a period of 32 samples
    return path


@pytest.mark.parametrize("speed", [0.05, 0.3, 4, Fraction(1, 3), np.float32(2), 16])
@pytest.mark.parametrize("suffix", ["mp4", "mkv", "webm"])
def test_frames_and_sound_last_longer_or_shorter(tmp_path: Path, suffix: str, speed: float) -> None:
    exact = speed if isinstance(speed, Fraction) else Fraction(str(speed))
    frames = 24 if speed < 1 else 96
    path = tones(tmp_path / f"a.{suffix}", speed, frames)
    times = frame_times(path)
    assert times == pytest.approx([i / (NTSC * exact) for i in range(frames)], abs=0.0011)
    samples, rate = sound(path)
    assert len(samples) / rate == pytest.approx(float(frames / (NTSC * exact)), abs=0.022)  # an AAC frame is 21.3 ms
    if suffix == "mkv":
        assert np.array_equal(samples, to_16_bit(np.tile(TONE, frames)))  # lossless at any speed


@pytest.mark.parametrize("speed", [0.25, 2])
def test_the_pitch_is_the_speeds(tmp_path: Path, speed: float) -> None:
    samples, rate = sound(tones(tmp_path / "a.mp4", speed, round(120 * speed)))
    window = samples[: round(1.8 * rate)]
    spectrum = np.abs(np.fft.rfft(window - window.mean()))
    assert spectrum.argmax() / 1.8 == pytest.approx(float(512 * NTSC * Fraction(speed) / 32), abs=1)


def test_a_gif_is_slow_or_drops_frames(tmp_path: Path) -> None:
    for speed, frames, shown in ((0.25, 12, [i * 4 / NTSC for i in range(12)]), (4, 24, [i / 50 for i in range(5)])):
        with VideoWriter(tmp_path / "a.gif", PONG, speed=speed, scale=1) as video:
            for i in range(frames):
                video.write(np.full_like(SCREEN, 4 * i))
        assert frame_times(video.path) == pytest.approx(shown, abs=0.02)


def test_pal(tmp_path: Path) -> None:
    game = next(game for game in atari.games.playable() if game.screen.format == "PAL")
    assert VideoWriter(tmp_path / "a.mkv", game, speed=0.5).fps == PAL / 2


def test_recorded_episodes(tmp_path: Path) -> None:
    with RecordVideo(atari.make("pong"), tmp_path / "one", scale=1, speed=0.5) as env:
        env.reset(seed=0)
        for _ in range(5):
            env.step(0)
    envs: Any = RecordVideo(atari.AtariVectorEnv("pong", 2), tmp_path / "two", scale=1, speed=0.5)
    envs.reset(seed=0)
    for _ in range(5):
        envs.step(np.zeros(2, int))
    envs.close()
    for name, frames in (("one/rl-video-episode-0.mp4", 21), ("two/rl-video-episode-0.mp4", 21)):
        times = frame_times(tmp_path / name)
        assert times == pytest.approx([2 * i / NTSC for i in range(frames)], abs=0.0011)


def test_a_replay(tmp_path: Path) -> None:
    replay = Replay.load(record(tmp_path / "a.a26r", "pong", 10))
    path = replay.render(tmp_path / "a.mkv", scale=1, speed=4)
    assert len(video_frames(path)) == replay.frames_total
    assert frame_times(path)[-1] == pytest.approx((replay.frames_total - 1) / (4 * NTSC), abs=0.0011)


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"speed": 0}, ValueError, r"speed must be within 0\.05\.\.16, where 1 is the console's speed, got 0"),
        ({"speed": 17}, ValueError, "speed must be within"),
        ({"speed": float("nan")}, ValueError, "speed must be within"),
        ({"speed": "fast"}, TypeError, "speed is a number, such as 0.5 for half the console's speed, got 'fast'"),
        ({"speed": True}, TypeError, "speed is a number"),
        ({"speed": 2, "fps": 30}, ValueError, "fps=30 and speed=2 both decide how fast a video is; leave one out"),
        ({"speed": 2, "format": "png"}, ValueError, "a PNG has no speed, got speed=2; leave it out"),
    ],
)
def test_wrong_speeds(tmp_path: Path, options: dict[str, Any], error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        RecordVideo(atari.make("pong"), tmp_path / "v", **options)
    with pytest.raises(error, match=text):
        RecordVideo(atari.AtariVectorEnv("pong", 1), tmp_path / "v", **options)
    name = "%06d.png" if options.get("format") else "a.mp4"
    rest = {key: value for key, value in options.items() if key != "format"}
    with pytest.raises(error, match=text):
        VideoWriter(tmp_path / name, PONG, **rest)
    assert not list(tmp_path.iterdir())


def test_frames_of_other_sources_have_fps_alone(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"speed=0\.5 is for a Game, whose frame rate is known; multiply fps by it"):
        VideoWriter(tmp_path / "a.mp4", (210, 160), 60, speed=0.5)
