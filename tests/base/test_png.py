"""PNG files, as OpenCV, Pillow and FFmpeg read them."""

import io
import struct

import av
import cv2
import numpy as np
import pytest

from atari.base import png


def noise(*shape: int) -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, shape, np.uint8)


def played(data: bytes) -> list[np.ndarray]:
    """The images that a browser shows of an animated PNG; wrong checksums fail."""
    with av.open(io.BytesIO(data), format="apng") as file:
        file.streams.video[0].codec_context.options = {"err_detect": "crccheck+explode"}
        return [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]


@pytest.mark.parametrize("size", [(1, 1), (210, 160), (7, 300), (300, 7)])
def test_every_pixel_is_stored(size: tuple[int, int]) -> None:
    pillow = pytest.importorskip("PIL.Image")
    gray, rgb = noise(*size), noise(*size, 3)
    assert np.array_equal(cv2.imdecode(np.frombuffer(png.png(gray), np.uint8), cv2.IMREAD_UNCHANGED), gray)
    assert np.array_equal(cv2.imdecode(np.frombuffer(png.png(rgb), np.uint8), cv2.IMREAD_UNCHANGED)[..., ::-1], rgb)
    for image in (gray, rgb, rgb[::-1, ::-1], np.asfortranarray(gray)):
        with pillow.open(io.BytesIO(png.png(image))) as opened:
            assert np.array_equal(np.asarray(opened), image)


def test_a_screen_is_small() -> None:
    screen = np.zeros((210, 160, 3), np.uint8)
    screen[90:, 40:80] = (200, 72, 72)
    assert len(png.png(screen)) < 500


def test_an_animation_shows_its_images_and_loops() -> None:
    first = noise(50, 80, 3)
    second = first.copy()
    second[10:20, 30:35] += 1
    file, count = png.animation([first, second, second, first], 30)
    assert count == 4
    for shown, image in zip(played(file), (first, second, second, first), strict=True):
        assert np.array_equal(shown, image)
    assert struct.pack(">4s2I", b"acTL", 4, 0) in file
    assert len(file) < 2 * len(png.png(first)), "a frame holds what has changed"


def test_an_animation_ends_before_it_is_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(png, "MAX_ANIMATION_SIZE", 50_000)
    generator = np.random.default_rng(0)
    file, count = png.animation((generator.integers(0, 256, (50, 80, 3), np.uint8) for _ in range(20)), 30)
    assert count == 4
    assert len(file) < 51_000
    assert len(played(file)) == 4
    large = np.zeros((50, 80, 3), np.uint8)
    assert png.animation([large, large], 30)[1] == 2  # without a change


def test_an_animation_needs_an_image() -> None:
    with pytest.raises(ValueError, match="needs an image"):
        png.animation([], 30)


def test_pooled_images_keep_the_brightest_value() -> None:
    images = list(noise(5, 4, 4, 3))
    shown = list(png.pooled(images, 2))
    assert [np.array_equal(one, np.max(images[at : at + 2], 0)) for one, at in zip(shown, (0, 2, 4), strict=True)] == [
        True
    ] * 3
