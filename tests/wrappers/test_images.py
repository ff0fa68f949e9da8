"""`resize_image` and `rgb_to_gray` beside OpenCV, over all sizes and colours."""

import os
import threading
from typing import Any

import cv2
import numpy as np
import pytest

from atari.cores import ByteArray
from atari.wrappers import resize_image, rgb_to_gray

SEED = int.from_bytes(os.urandom(4), "little")
"""The seed of the sampled sizes, another one in each run; a failure shows it."""

SCREENS = [(210, 160), (250, 160)]


def image(random: np.random.Generator, shape: tuple[int, ...]) -> ByteArray:
    """Noise, or few values, so that many means lie half way between two numbers; in some, rows repeat the row above."""
    values = random.integers(0, 256, random.choice((2, 3, 6, 256)), dtype=np.uint8)
    made = random.choice(values, shape)
    return made[np.arange(shape[0]) // random.integers(1, 4)].copy()


def check(source: ByteArray, rows: int, columns: int) -> None:
    expected = cv2.resize(source, (columns, rows), interpolation=cv2.INTER_AREA)
    made = resize_image(source, (rows, columns))
    assert (made.shape, made.dtype) == ((rows, columns, *source.shape[2:]), np.uint8)
    assert np.array_equal(made, expected.reshape(made.shape)), f"{source.shape} to {rows} x {columns}, {SEED=}"


def divisors(number: int) -> list[int]:
    return [divisor for divisor in range(1, number + 1) if number % divisor == 0]


@pytest.mark.parametrize("screen", SCREENS)
@pytest.mark.parametrize("colours", [(), (1,), (3,)])
def test_equals_opencv_at_sampled_sizes_of_screens(screen: tuple[int, int], colours: tuple[int, ...]) -> None:
    random = np.random.default_rng(SEED)
    for _ in range(250):
        check(image(random, (*screen, *colours)), *(int(random.integers(1, side + 1)) for side in screen))


@pytest.mark.parametrize("colours", [(), (3,)])
def test_equals_opencv_at_every_number_of_rows_and_of_columns(colours: tuple[int, ...]) -> None:
    random = np.random.default_rng(SEED)
    for rows in range(1, 211):
        check(image(random, (210, 160, *colours)), rows, int(random.choice((1, 7, 80, 84, 160))))
    for columns in range(1, 161):
        check(image(random, (210, 160, *colours)), int(random.choice((1, 7, 84, 105, 210))), columns)


@pytest.mark.parametrize("channels", [0, 1, 2, 3, 4])
def test_equals_opencv_for_odd_images_smaller_and_larger(channels: int) -> None:
    random = np.random.default_rng(SEED)
    for _ in range(400):
        size = random.integers(1, random.choice((5, 60, 200)), 2)
        target = (
            random.integers(1, 3 * side + 2) if random.random() < 0.7 else random.integers(1, side + 1) for side in size
        )
        check(image(random, (*size.tolist(), *[channels][: channels > 0])), *map(int, target))


@pytest.mark.parametrize("colours", [(), (2,), (3,), (4,)])
def test_equals_opencv_at_whole_scales(colours: tuple[int, ...]) -> None:
    """OpenCV sums blocks there, and rounds halves in blocks of 2 x 2 differently."""
    random = np.random.default_rng(SEED)
    for rows in divisors(210):
        for columns in divisors(160):
            check(image(random, (210, 160, *colours)), rows, columns)


def test_equals_opencv_when_screens_grow() -> None:
    random = np.random.default_rng(SEED)
    for rows, columns in [(211, 160), (210, 161), (420, 320), (84, 200), (300, 84), (256, 256), (1000, 3), (2, 999)]:
        for colours in ((), (3,)):
            check(image(random, (210, 160, *colours)), rows, columns)


def test_gray_of_every_colour_is_opencvs() -> None:
    green, blue = np.mgrid[0:256, 0:256].astype(np.uint8)
    for red in range(256):
        colours = np.stack([np.full_like(green, red), green, blue], 2)
        assert np.array_equal(rgb_to_gray(colours), cv2.cvtColor(colours, cv2.COLOR_RGB2GRAY)), red


@pytest.mark.parametrize("columns", [1, 2, 15, 16, 17, 160, 333])
def test_gray_of_rows_of_any_length(columns: int) -> None:
    random = np.random.default_rng(SEED)
    for rows in (1, 2, 50):
        colours = image(random, (rows, columns, 3))
        assert np.array_equal(rgb_to_gray(colours), cv2.cvtColor(colours, cv2.COLOR_RGB2GRAY)), f"{rows=}, {SEED=}"


def test_any_memory_order_is_taken_and_nothing_is_shared() -> None:
    colours = image(np.random.default_rng(SEED), (30, 40, 3))
    for strided in (colours[::-1], colours[:, ::2], colours.transpose(1, 0, 2)):
        assert np.array_equal(resize_image(strided, (7, 9)), resize_image(strided.copy(), (7, 9)))
        assert np.array_equal(rgb_to_gray(strided), rgb_to_gray(strided.copy()))
    same = resize_image(colours, (30, 40))
    assert np.array_equal(same, colours)
    assert not np.shares_memory(same, colours)
    colours.setflags(write=False)
    resize_image(colours, (7, 9)), rgb_to_gray(colours)


@pytest.mark.parametrize(
    ("source", "shape", "error", "text"),
    [
        (np.zeros((4, 4)), (2, 2), TypeError, "an image must be a C-contiguous array of uint8, got dtype('float64')"),
        ("image", (2, 2), TypeError, "C-contiguous array of uint8, got dtype('<U5')"),
        (None, (2, 2), TypeError, "C-contiguous array of uint8, got dtype('O')"),
        (np.zeros(4, np.uint8), (2, 2), ValueError, "must have the shape (rows, columns) or (rows, columns, channels)"),
        (np.zeros((1, 2, 3, 4), np.uint8), (2, 2), ValueError, "each within 1..32768, got (1, 2, 3, 4)"),
        (np.zeros((0, 4), np.uint8), (2, 2), ValueError, "each within 1..32768, got (0, 4)"),
        (np.zeros((1, 32769), np.uint8), (2, 2), ValueError, "got (1, 32769)"),
        (np.zeros((4, 4), np.uint8), (0, 2), ValueError, "shape must be within 1..32768, got 0"),
        (np.zeros((4, 4), np.uint8), (2, 32769), ValueError, "shape must be within 1..32768, got 32769"),
        (np.zeros((4, 4), np.uint8), (2, 2.0), TypeError, "shape must be an integer within 1..32768, got 2.0"),
        (np.zeros((4, 4), np.uint8), 2, TypeError, "shape must be two integers (rows, columns), got 2"),
    ],
)
def test_wrong_arguments(source: Any, shape: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error) as raised:
        resize_image(source, shape)
    assert text in str(raised.value)


@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 1), (4, 4, 4), (3,), (0, 4, 3)])
def test_what_is_no_rgb_image(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="image must have the shape"):
        rgb_to_gray(np.zeros(shape, np.uint8))


def test_the_binding_checks_its_sizes_itself() -> None:
    import atari._emulator as _emulator

    for rows, columns in ((0, 1), (1, 0), (-1, 5), (32769, 1), (1, 2**31 - 1)):
        with pytest.raises(ValueError, match=f"within 1..32768, got {rows} and {columns}"):
            _emulator.resize_image(np.zeros((4, 4), np.uint8), rows, columns)
    with pytest.raises(TypeError, match="C-contiguous"):
        _emulator.resize_image(np.zeros((4, 4), np.uint8)[::2], 1, 1)


def test_threads_resize_at_once() -> None:
    sources = [image(np.random.default_rng(seed), (210, 160, 3)) for seed in range(4)]
    expected = [resize_image(source, (84, 84)) for source in sources]
    wrong: list[int] = []

    def work(number: int) -> None:
        for _ in range(50):
            if not np.array_equal(resize_image(sources[number], (84, 84)), expected[number]):
                wrong.append(number)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong
