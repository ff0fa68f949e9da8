"""`VideoWriter`: files read back have the written frames at the console's frame rate."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from film import film
from video_reader import NTSC, Screen, video_frames

import atari
from atari.cores import NativeCore
from atari.recording import VideoWriter
from atari.recording.video.writer import frame_rate


def moving_bar(frames: int, size: tuple[int, int] = (210, 160)) -> list[Screen]:
    """Screens with a white column that moves to the right by one pixel a frame."""
    screens = np.zeros((frames, *size, 3), np.uint8)
    for i, screen in enumerate(screens):
        screen[:, i % size[1]] = 255
    return list(screens)


def test_frame_rate_follows_from_the_colour_clock() -> None:
    assert frame_rate(atari.games["breakout"]) == NTSC == Fraction(315_000_000, 88 * 228 * 262)
    assert frame_rate(atari.games["air_raid"]) == Fraction(3_546_895, 228 * 312)
    assert float(frame_rate(atari.games["pong"])) == pytest.approx(59.9228, abs=1e-4)
    assert float(frame_rate(atari.games["air_raid"])) == pytest.approx(49.8608, abs=1e-4)


def test_every_game_has_a_frame_rate_and_an_even_size(tmp_path: Path) -> None:
    for game in atari.games.values():
        assert 49 < frame_rate(game) < 60
        writer = VideoWriter(tmp_path / f"{game.id}.mp4", game, scale=1)
        assert writer.fps == frame_rate(game)
        writer.close()


@pytest.mark.parametrize(
    ("fps", "expected"), [(NTSC / 4, NTSC / 4), (15, 15), (29.97, Fraction(2997, 100)), (np.float32(12.5), 12.5)]
)
def test_any_rate_is_kept_exactly(tmp_path: Path, fps: Any, expected: Any) -> None:
    with av.open(str(film(tmp_path / "a.mp4", moving_bar(5), fps, scale=1))) as container:
        assert container.streams.video[0].average_rate == expected


def test_pixels_can_be_square(tmp_path: Path) -> None:
    path = film(tmp_path / "a.mp4", [np.zeros((40, 60, 3), np.uint8)], 30, scale=1, pixel_aspect=(1, 1))
    with av.open(str(path)) as container:
        assert (container.streams.video[0].width, container.streams.video[0].height) == (60, 40)
    with pytest.raises(ValueError, match=r"the video would be 61x40, but MP4 .* needs even sides"):
        VideoWriter(path, (40, 61), 30, scale=1, pixel_aspect=(1, 1))
    with pytest.raises(TypeError, match=r"pixel_aspect is \(columns, rows\)"):
        VideoWriter(path, (40, 60), 30, pixel_aspect=2)  # type: ignore[arg-type]


@pytest.mark.parametrize("scale", [2, 4, 6])
def test_each_pixel_of_a_game_becomes_a_block_of_its_colour(tmp_path: Path, scale: int) -> None:
    core = NativeCore("seaquest", seed=1)
    core.reset()
    screens = []
    for action in (0, 1, 2, 3, 4, 5):
        for _ in range(5):
            core.act(action)
        screens.append(core.screen_rgb())
    decoded = video_frames(film(tmp_path / "a.mp4", screens, frame_rate(core.game), scale=scale))
    assert len(decoded) == len(screens)
    for screen, image in zip(screens, decoded, strict=True):
        expected = screen.repeat(scale, axis=0).repeat(2 * scale, axis=1)
        difference = np.abs(image.astype(int) - expected)
        assert difference.mean() < 1.5
        assert (difference > 16).mean() < 0.001


def test_colours_are_right_whether_or_not_a_reader_looks_at_what_the_file_says_of_them(tmp_path: Path) -> None:
    colours = np.array([(200, 72, 72), (66, 72, 200), (72, 160, 72), (255, 255, 0), (0, 28, 136)], np.uint8)
    path = film(tmp_path / "a.mp4", [np.tile(colours.repeat(20, axis=0), (100, 1, 1))] * 3)
    with av.open(str(path)) as container:
        context = container.streams.video[0].codec_context
        assert (context.colorspace, context.color_range) == (6, 1)  # BT.601, limited
    middles = video_frames(path)[0][100, 40::80].astype(int)
    assert np.abs(middles - colours).max() <= 3
    _, blue_green_red = cv2.VideoCapture(str(path)).read()  # OpenCV does not look
    assert np.abs(blue_green_red[100, 40::80, ::-1].astype(int) - colours).max() <= 3


def test_frames_are_in_the_order_of_writing(tmp_path: Path) -> None:
    shown = video_frames(film(tmp_path / "a.mp4", moving_bar(100, (32, 160))))
    columns = [int(image.sum(axis=(0, 2), dtype=int).argmax()) // 4 for image in shown]
    assert columns == list(range(100))


def test_a_view_that_is_not_contiguous_is_written_as_it_looks(tmp_path: Path) -> None:
    screen = np.zeros((210, 160, 3), np.uint8)
    screen[:, 80:] = 255
    (image,) = video_frames(film(tmp_path / "a.mp4", [screen[:, ::-1]]))
    assert image[:, :310].min() > 240
    assert image[:, 330:].max() < 15


def test_closing_twice_does_nothing_and_writing_then_raises(tmp_path: Path) -> None:
    video = VideoWriter(tmp_path / "a.mp4", (32, 32), NTSC)
    for screen in moving_bar(3, (32, 32)):
        video.write(screen)
    video.close()
    size = video.path.stat().st_size
    video.close()
    assert video.path.stat().st_size == size
    with pytest.raises(ValueError, match="is closed"):
        video.write(screen)
    assert len(video_frames(video.path)) == 3


def test_file_is_playable_after_an_exception(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), VideoWriter(tmp_path / "a.mp4", (32, 32), NTSC) as video:  # noqa: PT012
        for screen in moving_bar(70, (32, 32)):
            video.write(screen)
        raise ZeroDivisionError
    assert len(video_frames(tmp_path / "a.mp4")) == 70


def test_no_screen_no_file(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.mp4", (210, 160), NTSC):
        assert not (tmp_path / "a.mp4").exists()
    assert not list(tmp_path.iterdir())


def test_an_older_video_is_there_until_a_second_is_written(tmp_path: Path) -> None:
    path = tmp_path / "a.mp4"
    path.write_bytes(b"older")
    with VideoWriter(path, (16, 16), 10, scale=1) as video:
        for _ in range(10):
            assert path.read_bytes() == b"older"
            video.write(np.zeros((16, 16, 3), np.uint8))
        video.write(np.zeros((16, 16, 3), np.uint8))
        assert path.read_bytes() != b"older"
        assert [one.name for one in tmp_path.iterdir()] == ["a.mp4"]
    assert len(video_frames(path)) == 11


def test_missing_folders_are_made_and_an_old_file_replaced(tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "a.MP4"
    for frames in (9, 4):
        film(path, moving_bar(frames, (32, 32)))
    assert len(video_frames(path)) == 4


@pytest.mark.parametrize(
    ("arguments", "error", "text"),
    [
        ({"path": "a.avi"}, ValueError, r"name must end in one of .*, got '.*a\.avi'"),
        *[
            ({"path": name}, ValueError, r"must have a place for its number, such as '%06d\.png', got ")
            for name in ("%s.png", "%d%d.png", "%.png", "100%.png")
        ],
        ({"path": "a.gif", "sound": True}, ValueError, "GIF has no sound; write it with sound=False"),
        ({"path": "%06d.png", "sound": True}, ValueError, "PNG has no sound; write it with sound=False"),
        ({"size": (210, 160, 3)}, TypeError, r"size is a Game, or \(rows, columns\)"),
        ({"size": 210}, TypeError, r"size is a Game, or \(rows, columns\)"),
        ({"size": (0, 160)}, ValueError, "side of size must be within 1"),
        ({"size": (210.0, 160)}, TypeError, "side of size must be an integer"),
        ({"size": (211, 160), "scale": 1}, ValueError, "320x211, but MP4 .* needs even sides"),
        ({"size": (2000, 3000)}, ValueError, "12000x4000, but MP4 .* needs even sides up to 8192"),
        ({"scale": 0}, ValueError, "scale must be within 1..16"),
        ({"scale": 1.5}, TypeError, "scale must be an integer"),
        ({"fps": 0}, ValueError, "fps must be within"),
        ({"fps": float("nan")}, ValueError, "fps must be within"),
        ({"fps": "60"}, TypeError, "fps is a number of frames a second, which only a Game implies, got '60'"),
        ({"fps": None}, TypeError, "fps is a number of frames a second, which only a Game implies, got None"),
    ],
)
def test_wrong_arguments_are_refused_before_a_file_is_made(
    tmp_path: Path, arguments: dict[str, Any], error: type[Exception], text: str
) -> None:
    options = {"path": "a.mp4", "size": (210, 160), "fps": 60, **arguments}
    folder = tmp_path / "folder"
    with pytest.raises(error, match=text):
        VideoWriter(folder / options.pop("path"), **options)
    assert not folder.exists()


@pytest.mark.parametrize(
    ("screen", "error", "text"),
    [
        (np.zeros((210, 160), np.uint8), ValueError, r"shape \(210, 160, 3\), got \(210, 160\)"),
        (np.zeros((160, 210, 3), np.uint8), ValueError, r"got \(160, 210, 3\)"),
        (np.zeros((210, 160, 3), np.float32), TypeError, "uint8 array .* got float32"),
        ([[[0, 0, 0]]], TypeError, "uint8 array .* got list"),
        (None, TypeError, "got NoneType"),
    ],
)
def test_wrong_screens_are_refused_and_harm_nothing(
    tmp_path: Path, screen: Any, error: type[Exception], text: str
) -> None:
    with VideoWriter(tmp_path / "a.mp4", (210, 160), NTSC) as video:
        video.write(np.zeros((210, 160, 3), np.uint8))
        with pytest.raises(error, match=text):
            video.write(screen)
        video.write(np.zeros((210, 160, 3), np.uint8))
    assert len(video_frames(video.path)) == 2


def test_a_place_that_cannot_be_written_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="file"):
        VideoWriter(tmp_path / "file" / "a.mp4", (210, 160), NTSC)
    (tmp_path / "folder.mp4").mkdir()
    with pytest.raises(IsADirectoryError):
        VideoWriter(tmp_path / "folder.mp4", (210, 160), NTSC)


def test_a_caption_without_a_line_is_refused(tmp_path: Path) -> None:
    (screen,) = moving_bar(1, (32, 32))
    with VideoWriter(tmp_path / "a.mp4", (32, 32), NTSC) as video:
        with pytest.raises(ValueError, match="make the VideoWriter with caption_lines=1, got 'hello'"):
            video.write(screen, None, "hello")
        video.write(screen)


def test_the_last_frame_of_a_gif_lasts_as_long_as_the_others(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "a.gif", atari.games["pong"], speed=0.1, scale=1) as video:
        for screen in moving_bar(5):
            video.write(screen)
    data = (tmp_path / "a.gif").read_bytes()
    delays = [int.from_bytes(data[place + 4 : place + 6], "little") for place in _extensions(data)]
    assert len(delays) == 5
    assert min(delays) >= 16  # hundredths of a second


def _extensions(data: bytes) -> list[int]:
    """The places of the graphic control extensions of a GIF."""
    return [place for place in range(len(data) - 8) if data[place : place + 3] == b"\x21\xf9\x04"]
