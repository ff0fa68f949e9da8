"""The content of files of each format, read back with PyAV and OpenCV."""

import re
import subprocess
import sys
import textwrap
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from film import film
from video_reader import NTSC, PAL, Screen, frame_times, video_frames

from atari.cores import NativeCore
from atari.recording import VideoWriter
from atari.recording.video.formats import FORMATS
from atari.recording.video.images import Palette, add_caption, enlarge, line_height

SOUNDING = ["mp4", "mkv", "webm"]


def screens(count: int, game: str = "seaquest") -> Iterator[Screen]:
    core = NativeCore(game, seed=1)
    core.reset()
    for i in range(count):
        core.act([1, 2, 3, 4, 5, 0][i // 5 % 6])
        yield core.screen_rgb()


def enlarged(screen: Screen, scale: int) -> Screen:
    return screen.repeat(scale, axis=0).repeat(2 * scale, axis=1)


@pytest.mark.parametrize(
    ("suffix", "codec", "pixels"),
    [("mp4", "h264", "yuv420p"), ("mkv", "ffv1", "bgr0"), ("webm", "vp9", "yuv420p"), ("gif", "gif", "bgra")],
)
@pytest.mark.parametrize("fps", [NTSC, PAL])
def test_codec_size_rate_and_duration(tmp_path: Path, suffix: str, codec: str, pixels: str, fps: Fraction) -> None:
    path = film(tmp_path / f"a.{suffix}", screens(30), fps)
    with av.open(str(path)) as container:
        (stream,) = container.streams
        context = stream.codec_context
        assert context.name.removeprefix("lib") == codec
        assert (stream.width, stream.height, context.pix_fmt) == (640, 420, pixels)
        assert container.duration / av.time_base == pytest.approx(float(30 / fps), abs=0.02)
        if suffix != "gif":
            assert stream.average_rate == pytest.approx(float(fps), abs=0.001)
        if suffix == "mp4":
            facts = stream.average_rate, stream.frames, stream.duration * stream.time_base
            assert facts == (fps, 30, 30 / fps)
    times = frame_times(path)
    if suffix == "gif":
        assert np.diff(times).min() >= 0.0199  # shorter ones are shown at a tenth of the speed
    else:
        assert times == pytest.approx([i / fps for i in range(30)], abs=0.001)


@pytest.mark.parametrize("scale", [1, 2])
def test_mkv_loses_no_pixel(tmp_path: Path, scale: int) -> None:
    written = list(screens(15))
    read = video_frames(film(tmp_path / "a.mkv", written, scale=scale))
    assert all(np.array_equal(a, enlarged(b, scale)) for a, b in zip(read, written, strict=True))


def test_webm_is_nearly_what_was_written(tmp_path: Path) -> None:
    written = list(screens(15))
    for image, screen in zip(video_frames(film(tmp_path / "a.webm", written)), written, strict=True):
        assert np.abs(image.astype(int) - enlarged(screen, 2)).mean() < 3


def test_a_gif_has_exact_colours_and_drops_one_frame_in_six(tmp_path: Path) -> None:
    written = list(screens(60))
    path = film(tmp_path / "a.gif", written)
    shown = sorted({int(i * 50 / NTSC): i for i in reversed(range(60))}.values())
    assert len(shown) == 50
    read = video_frames(path)
    assert len(read) == len(shown)
    assert all(np.array_equal(a, enlarged(written[i], 2)) for a, i in zip(read, shown, strict=True))
    assert frame_times(path) == pytest.approx([i / 50 for i in range(50)])


def test_a_slow_gif_keeps_all_frames_and_their_times(tmp_path: Path) -> None:
    path = film(tmp_path / "a.gif", screens(30), NTSC / 4)
    assert frame_times(path) == pytest.approx([i * 4 / NTSC for i in range(30)], abs=0.02)


def test_a_palette_indexes_colours_and_maps_to_the_nearest_when_full() -> None:
    palette = Palette()
    grid = np.stack(np.meshgrid(*[np.arange(16) * 16] * 2, [0], indexing="ij"), axis=-1).reshape(16, 16, 3)
    image = grid.astype(np.uint8)
    numbers = palette.indices(image)
    assert np.array_equal(palette.colours[numbers][..., 1:], image)
    assert (palette.colours[:, 0] == 255).all()
    further = palette.indices(np.full((1, 1, 3), (34, 16, 3), np.uint8))
    assert palette.colours[further].tolist() == [[[255, 32, 16, 0]]]
    assert np.array_equal(palette.indices(image), numbers)


def test_a_png_sequence_is_a_file_a_screen(tmp_path: Path) -> None:
    written = list(screens(12))
    film(tmp_path / "new" / "game %03d.png", written, scale=1)
    files = sorted((tmp_path / "new").iterdir())
    assert [file.name for file in files] == [f"game {i:03}.png" for i in range(12)]
    for file, screen in zip(files, written, strict=True):
        assert np.array_equal(cv2.imread(str(file))[..., ::-1], enlarged(screen, 1))


def test_a_png_without_a_place_for_a_number_is_one_picture(tmp_path: Path) -> None:
    (written,) = screens(1)
    with VideoWriter(tmp_path / "100%" / "a.png", (210, 160), NTSC, caption_lines=1) as picture:
        picture.write(written, caption="the first")
        with pytest.raises(ValueError, match=r"a\.png is one picture, and has its frame; name a picture of each frame"):
            picture.write(written)
    (file,) = (tmp_path / "100%").iterdir()
    image = cv2.imread(str(file))[..., ::-1]
    assert image.shape == (420 + line_height(2), 640, 3)
    assert np.array_equal(image[:420], enlarged(written, 2))


def test_names_that_mean_something_to_ffmpeg_are_only_names(tmp_path: Path) -> None:
    for name in ("a:b.mp4", "pipe:1.mkv", "50%d.webm", "ü -.gif"):
        assert len(video_frames(film(tmp_path / name, [np.zeros((32, 32, 3), np.uint8)]))) == 1


def test_captions_are_below_the_frame(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mkv", (210, 160), NTSC, caption_lines=3) as video:
        written = list(screens(3))
        for screen, caption in zip(written, ["", "one", "one\ntwo\nthree\nfour"], strict=True):
            video.write(screen, caption=caption)
    none, one, three = video_frames(video.path)
    assert none.shape == (420 + 3 * line_height(2), 640, 3)
    assert np.array_equal(three[:420], enlarged(written[2], 2))
    assert not none[420:].any()
    lines = [[band.any() for band in np.split(image[420:], 3)] for image in (one, three)]
    assert lines == [[True, False, False], [True, True, True]]


@pytest.mark.parametrize("scale", [1, 2, 3])
def test_the_characters_of_captions_differ_and_keep_to_their_places(scale: int) -> None:
    empty = np.zeros((2, 320 * scale, 3), np.uint8)
    text = "".join(map(chr, range(33, 86)))
    margin = 2 * scale
    below = add_caption(empty, text, 1, scale)[2:, :, 0]
    assert not below[:margin].any()
    assert not below[:, :margin].any()
    cells = [cell.tobytes() for cell in np.split(below[:, margin:], 53, axis=1)]
    assert len(set(cells)) == 53
    second = slice(margin + 6 * scale, margin + 12 * scale)
    assert add_caption(empty, f" {text[0]}é", 1, scale)[2:, second, 0].tobytes() == cells[0]
    assert add_caption(empty, "x" * 1000, 1, scale).shape == (2 + line_height(scale), 320 * scale, 3)


def test_a_descender_does_not_touch_the_line_below() -> None:
    lines = add_caption(np.zeros((2, 320, 3), np.uint8), "qbert-pqn\nscore 850", 2, 1)[2:, :, 0]
    drawn = lines.any(axis=1)
    assert np.flatnonzero(drawn).tolist() == [*range(2, 10), *range(12, 19)]


def test_enlarging_repeats_pixels() -> None:
    screen = np.random.default_rng(0).integers(0, 256, (7, 5, 3), np.uint8)
    for scale in (1, 2, 5):
        assert np.array_equal(enlarge(screen, 2 * scale, scale), enlarged(screen, scale))
    assert np.array_equal(enlarge(screen[:, ::-1], 4, 2), enlarged(screen[:, ::-1], 2))


def run(program: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run a program in a folder; it has `sys`, `resource`, numpy as `np`, `noise` and `VideoWriter`."""
    imports = "import os, resource, sys\nimport numpy as np\nfrom atari.recording import VideoWriter\n"
    words = [sys.executable, "-c", f"{imports}noise = np.random.default_rng(0)\n{textwrap.dedent(program)}"]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


def test_a_killed_process_leaves_all_but_the_last_second(tmp_path: Path) -> None:
    program = """
        names = "a.mp4", "a.mkv", "a.webm", "a.gif"
        videos = [VideoWriter(name, (80, 80), 50, scale=1, sound=name[-3:] != "gif") for name in names]
        screen = np.zeros((80, 80, 3), np.uint8)
        for i in range(200):
            screen[:, i % 80] = i
            for video in videos:
                video.write(screen, noise.integers(128, 248, 512).astype(np.uint8))
        os.kill(os.getpid(), 9)
    """
    assert run(program, tmp_path).returncode == -9
    for suffix in (*SOUNDING, "gif"):
        assert 150 <= len(video_frames(tmp_path / f"a.{suffix}")) < 200, suffix
        if suffix in SOUNDING:
            with av.open(str(tmp_path / f"a.{suffix}")) as container:
                assert sum(frame.samples / frame.sample_rate for frame in container.decode(audio=0)) >= 3, suffix


def test_a_full_disk_is_an_error_and_no_crash(tmp_path: Path) -> None:
    cases = [
        ("a.mp4", 0),
        ("b.mp4", 1000),
        *[(name, 30_000) for name in ("c.mp4", "a.mkv", "a.webm", "a.gif", "%d.png")],
    ]
    program = f"""
        for name, limit in {cases}:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, -1))
            try:
                with VideoWriter(name, (128, 128), 60, scale=1, sound=name[-3:] not in ("gif", "png")) as video:
                    for _ in range(100):
                        video.write(noise.integers(0, 255, (128, 128, 3), dtype=np.uint8), np.zeros(512, np.uint8))
            except OSError as error:
                print(name, error.strerror)
            try:
                video.write(np.zeros((128, 128, 3), np.uint8))
            except ValueError as error:
                print(str(error).rpartition("is closed; ")[2])
    """
    result = run(program, tmp_path)
    assert (result.returncode, result.stderr) == (0, "")
    line = r"{} File too large(; incomplete, after \d+ frames)?\nmake a new VideoWriter\n"
    assert re.fullmatch("".join(line.format(re.escape(name)) for name, _ in cases), result.stdout)


def test_memory_does_not_grow(tmp_path: Path) -> None:
    program = """
        screens, samples = np.zeros((50, 64, 64, 3), np.uint8), noise.integers(128, 248, (50, 512)).astype(np.uint8)
        for i, screen in enumerate(screens):
            screen[:, i] = 255
        videos = [VideoWriter(f"a.{suffix}", (64, 64), 60, scale=1, sound=True) for suffix in ("mp4", "mkv", "webm")]
        for i in range(500):
            for video in videos:
                video.write(screens[i % 50].copy(), samples[i % 50])
            if i == 150:
                early = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - early)
    """
    result = run(program, tmp_path)
    assert int(result.stdout) < 3000  # 350 screens alone would be 4 MB


def test_every_format_is_described() -> None:
    assert list(FORMATS) == [".mp4", ".mkv", ".webm", ".gif", ".png"]
    # Python 3.13 removes the indentation of docstrings.
    descriptions = [line.strip() for line in str(VideoWriter.__doc__).splitlines()]
    assert all(any(line.startswith(f"{suffix} ") for line in descriptions) for suffix in FORMATS)
