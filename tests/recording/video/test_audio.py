"""The sound of videos: encoded samples, sample rates, and synchrony with the frames."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt
import pytest
from film import film
from video_reader import NTSC, PAL, frame_times, loudness, sound, video_frames

from atari.cores import NativeCore
from atari.recording import VideoWriter
from atari.recording.video.audio import AudioEncoder, to_16_bit
from atari.recording.video.formats import FORMATS

SILENCE = np.full(512, 128, np.uint8)
TONE = np.tile(np.repeat(np.array([128, 188], np.uint8), 16), 16)
BLACK, WHITE = np.zeros((32, 32, 3), np.uint8), np.full((32, 32, 3), 255, np.uint8)


def beeps(path: Path, frames: int, at: set[int], fps: Fraction = NTSC) -> Path:
    """A video that is white and loud for single frames."""
    shown = [(WHITE, TONE) if i in at else (BLACK, SILENCE) for i in range(frames)]
    return film(path, [screen for screen, _ in shown], fps, [samples for _, samples in shown], scale=1)


@pytest.mark.parametrize(("fps", "ratio"), [(NTSC, Fraction(27379, 17500)), (PAL, Fraction(1_333_800, 709_379))])
def test_the_ratio_of_the_rates_is_exact_so_that_nothing_drifts_in_any_time(fps: Fraction, ratio: Fraction) -> None:
    with av.open("unused", "w", format="null") as container:
        track = AudioEncoder(av, container, FORMATS[".mp4"], fps)
    assert track._ratio == ratio
    assert 512 * fps * ratio == 48_000  # the samples of a second become a second
    samples = sum(frame.samples for _ in range(2000) for frame in resampled(track))
    assert abs(samples - 2000 * 512 * ratio) < 64  # the resampler does so too, except for its delay


def resampled(track: AudioEncoder) -> list[Any]:
    frame = av.AudioFrame.from_ndarray(np.zeros((1, 512), np.int16), format="s16", layout="mono")
    frame.sample_rate = track._ratio.denominator
    return track._resampler.resample(frame)


@pytest.mark.parametrize("fps", [NTSC, PAL, Fraction(30)])
@pytest.mark.parametrize("suffix", ["mp4", "mkv", "webm"])
def test_sound_is_synchronous_with_its_frame(tmp_path: Path, suffix: str, fps: Fraction) -> None:
    path = beeps(tmp_path / f"a.{suffix}", 150, {0, 60, 140}, fps)
    samples, rate = sound(path)
    shown = [time for time, image in zip(frame_times(path), video_frames(path), strict=True) if image.mean() > 128]
    assert shown == pytest.approx([0, 60 / fps, 140 / fps], abs=0.001)
    loud = np.flatnonzero(np.abs(samples.astype(float) - np.median(samples)) > 0.25 * np.ptp(samples)) / rate
    if suffix != "mp4":  # the sound fades in
        assert min(loud) == pytest.approx(0, abs=0.002)
    for i in (60, 140):
        beep = loud[(loud > (i - 2) / fps) & (loud < (i + 3) / fps)]
        assert beep.min() == pytest.approx(i / fps, abs=0.002)
        assert beep.max() == pytest.approx((i + 1) / fps, abs=0.002)


@pytest.mark.parametrize(
    ("suffix", "codec", "rate"), [("mp4", "aac", 48_000), ("mkv", "flac", 30_680), ("webm", "opus", 48_000)]
)
def test_codec_rate_and_length(tmp_path: Path, suffix: str, codec: str, rate: int) -> None:
    path = beeps(tmp_path / f"a.{suffix}", 100, set())
    samples, found_rate = sound(path)
    assert len(samples) / found_rate == pytest.approx(100 / NTSC, abs=0.022)  # an AAC frame is 21.3 ms
    with av.open(str(path)) as container:
        assert container.duration / av.time_base == pytest.approx(100 / NTSC, abs=0.022)
        assert len(container.streams) == 2
        (stream,) = container.streams.audio
        assert stream.codec_context.name == codec
        assert (stream.sample_rate, stream.layout.name) == (rate, "mono")


def test_lossless_sound_is_what_was_written_at_exact_times(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    written = [rng.integers(128, 249, 512).astype(np.uint8) for _ in range(200)]
    path = film(tmp_path / "a.mkv", [BLACK] * 200, sound=written)
    decoded, _ = sound(path)
    assert np.array_equal(decoded, to_16_bit(np.concatenate(written)))
    assert np.array_equal(decoded // 128 + 128, np.concatenate(written))
    with av.open(str(path)) as container:
        first = 0
        for frame in container.decode(audio=0):
            assert float(frame.pts * frame.time_base) == pytest.approx(first / (512 * NTSC), abs=0.001)
            first += frame.samples


def test_a_tone_keeps_its_length_and_sounds_at_the_pitch_that_this_gives(tmp_path: Path) -> None:
    samples, rate = sound(film(tmp_path / "a.mp4", [BLACK] * 120, sound=[TONE] * 120))  # a period of 32 samples
    spectrum = np.abs(np.fft.rfft(samples[: 2 * rate] - samples.mean()))
    assert spectrum.argmax() / 2 == pytest.approx(float(512 * NTSC / 32), abs=1)  # 959 Hz


def test_a_games_sound_is_in_sync_with_its_frames(tmp_path: Path) -> None:
    core = NativeCore("seaquest", seed=1, sound=True)
    core.reset()
    moves = []
    with VideoWriter(tmp_path / "a.mp4", (32, 32), NTSC, sound=True) as video:
        for i in range(600):
            core.act([1, 0, 4, 1, 3, 0][i // 7 % 6])
            moves.append(np.ptp(core.audio().astype(float)))
            video.write(BLACK, core.audio())
    assert np.std(moves) > 1
    samples, rate = sound(video.path)
    heard = loudness(samples, rate, 600, float(NTSC))
    by_lag = {lag: np.corrcoef(moves[5:-5], np.roll(heard, -lag)[5:-5])[0, 1] for lag in range(-4, 5)}
    assert max(by_lag, key=lambda lag: by_lag[lag]) == 0
    assert by_lag[0] > 0.9


def test_no_samples_are_silence(tmp_path: Path) -> None:
    decoded, _ = sound(film(tmp_path / "a.mkv", [BLACK] * 3, sound=[TONE, None, TONE]))
    assert [bool(decoded[i : i + 512].any()) for i in (0, 512, 1024)] == [True, False, True]


def test_samples_are_not_looked_at_in_a_silent_video(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", (32, 32), NTSC) as video:
        video.write(BLACK, TONE)
    with av.open(str(video.path)) as container:
        assert not container.streams.audio


@pytest.mark.parametrize(
    ("samples", "error", "text"),
    [
        (np.zeros(511, np.uint8), ValueError, r"sound of this video has shape|\(512,\), got \(511,\)"),
        (np.zeros((2, 512), np.uint8), ValueError, r"got \(2, 512\)"),
        (np.zeros(512, np.int16), TypeError, "uint8 array .* got int16"),
        ([128] * 512, TypeError, "uint8 array .* got list"),
    ],
)
def test_wrong_samples_are_refused_and_harm_nothing(
    tmp_path: Path, samples: Any, error: type[Exception], text: str
) -> None:
    with VideoWriter(tmp_path / "a.mkv", (32, 32), NTSC, sound=True) as video:
        with pytest.raises(error, match=text):
            video.write(BLACK, samples)
        video.write(BLACK, TONE)
    assert len(video_frames(video.path)) == 1
    assert len(sound(video.path)[0]) == 512


def test_16_bits_around_0() -> None:
    values: npt.NDArray[np.uint8] = np.array([128, 248, 0, 255], np.uint8)
    assert to_16_bit(values).tolist() == [0, 15360, -16384, 16256]
