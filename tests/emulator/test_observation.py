"""Observations: pooling of gray frames, and scaling down, which equals OpenCV's to the byte."""

from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from atari_inspection import SimdLevel, best_simd_level, pool_gray, resize

from atari.cores import ByteArray, NativeCore

GAMES = {210: "ms_pacman", 214: "carnival", 220: "pooyan", 230: "journey_escape", 250: "mr_do"}
"""A game for each height of the screen."""

SIZES = [(84, 84), (64, 64), (96, 96), (42, 42), (110, 84), (84, 110), (100, 120), (13, 11), (1, 84), (200, 160)]
SIZES += [(105, 80), (210, 160), (70, 32), (7, 3), (1, 1), (210, 2)]
"""(height, width)."""

WHOLE_ROW = (1 << 20) - 1
"""The changes of a row, a bit for eight columns: all of them."""

LEVELS = [level for level in SimdLevel if level.value <= best_simd_level().value]
"""The SIMD levels that this processor supports."""

each_level = pytest.mark.parametrize("level", LEVELS)


def opencv(frame: ByteArray, height: int, width: int) -> ByteArray:
    return np.asarray(cv2.resize(frame, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def noise(rows: int, seed: int = 0) -> ByteArray:
    return np.random.default_rng(seed).integers(0, 256, (rows, 160), dtype=np.uint8)


def few_grays(rows: int, seed: int = 0) -> ByteArray:
    """Two to six grays, so that many means lie half way between two numbers."""
    random = np.random.default_rng(seed)
    grays = random.integers(0, 256, random.integers(2, 7), dtype=np.uint8)
    return random.choice(grays, (rows, 160))


def changes_of(early: ByteArray, late: ByteArray) -> list[int]:
    differ = (early[1:] != early[:-1]) | (late[1:] != late[:-1])
    changes: list[int] = (differ.reshape(-1, 20, 8).any(2) @ (1 << np.arange(20))).tolist()
    return [WHOLE_ROW, *changes]


def frames(game: str, count: int) -> Iterator[tuple[NativeCore, NativeCore]]:
    """Two machines, one of them one frame later than the other."""
    random = np.random.default_rng(1)
    early, late = (NativeCore(game, seed=1, repeat_action_probability=0.0) for _ in range(2))
    early.reset()
    late.reset()
    late.act(0)
    for _ in range(count):
        for action in random.integers(0, 18, 20).tolist():
            early.act(action)
            late.act(action)
        yield early, late


def test_half_way_means_occur() -> None:
    """The last bit of a sum decides how they round, so the frames of these tests must have them."""
    for seed in range(3):
        sums = few_grays(210, seed).repeat(2, 0).repeat(21, 1).reshape(84, 5, 84, 40).sum((1, 3), int)
        assert np.count_nonzero(sums % 200 == 100) > 10


@each_level
@pytest.mark.parametrize("rows", GAMES)
def test_equals_opencv(rows: int, level: SimdLevel) -> None:
    for height, width in SIZES:
        for seed in range(4):
            for frame in (noise(rows, seed), few_grays(rows, seed)):
                expected = opencv(frame, height, width)
                assert np.array_equal(resize(frame, height, width, level=level), expected), (height, width, seed)


@each_level
def test_equals_opencv_at_every_size(level: SimdLevel) -> None:
    """Every width with low images too, where a row is near the end; every height; sizes that divide one side or both."""
    widths = [(height, width) for width in range(1, 161) for height in (1, 2, 3, 84, 210)]
    for rows, sizes in {210: widths, 250: [(height, 84) for height in range(1, 251)]}.items():
        for height, width in sizes:
            frame = few_grays(rows, width + height)
            expected = opencv(frame, height, width)
            assert np.array_equal(resize(frame, height, width, level=level), expected), (height, width)
    for height, width in ((5, 84), (3, 80), (10, 84), (7, 160), (10, 159), (10, 160), (5, 80), (3, 1)):
        assert np.array_equal(resize(noise(10), height, width, level=level), opencv(noise(10), height, width))


@pytest.mark.parametrize("rows", [49, *GAMES])
def test_equals_opencv_at_sizes_that_divide_the_frame(rows: int) -> None:
    """OpenCV sums blocks only if 1 / (height / rows) is a whole number in doubles, which 1 / (1 / 210) is not."""
    for height in (height for height in range(1, rows + 1) if rows % height == 0):
        for width in (width for width in range(1, 161) if 160 % width == 0):
            for seed in range(5):
                frame = few_grays(rows, seed)
                assert np.array_equal(resize(frame, height, width), opencv(frame, height, width)), (height, width)


@each_level
@pytest.mark.parametrize("width", range(1, 161))
def test_some_rows_of_a_result(width: int, level: SimdLevel) -> None:
    """The rows before and after them are not written: `resize` checks it."""
    random = np.random.default_rng(width)
    frame, height = noise(210, width), int(random.choice((11, 12, 84, 209)))
    expected = opencv(frame, height, width)
    for _ in range(5):
        first = int(random.integers(height))
        last = min(height, first + int(random.integers(1, 5)))
        made = resize(frame, height, width, level=level, rows=(first, last))
        assert np.array_equal(made, expected[first:last]), (height, first, last)


@each_level
@pytest.mark.parametrize("rows", GAMES)
def test_games(rows: int, level: SimdLevel) -> None:
    """Two frames of a game, pooled and scaled: all rows, and only the columns that differ from the row above."""
    table = np.random.default_rng(2).integers(0, 256, 256, dtype=np.uint8)
    repeated = 0
    for cores in frames(GAMES[rows], 8):
        early, late = (core.screen() for core in cores)
        assert early.shape == (rows, 160)
        for first, second in ((early, late), (late, early), (late, late)):
            gray, changes = pool_gray(first, second, table, level=level)
            expected = np.maximum(table[first], table[second])
            assert np.array_equal(gray, expected)
            assert changes == changes_of(first, second)
            repeated += changes.count(0)
            for height, width in ((84, 84), (64, 64)):
                small = opencv(expected, height, width)
                assert np.array_equal(resize(gray, height, width, level=level), small)
                assert np.array_equal(resize(gray, height, width, changes, level=level), small)
    assert repeated > 100


@each_level
def test_gray_of_games(level: SimdLevel) -> None:
    """With ALE's grays as the table, pooling is the maximum of the cores' gray screens."""
    for game in ("breakout", "enduro"):
        for early, late in frames(game, 4):
            table = np.zeros(256, np.uint8)
            for core in (early, late):
                table[core.screen()] = core.screen_grayscale()
            gray, _ = pool_gray(early.screen(), late.screen(), table, level=level)
            assert np.array_equal(gray, np.maximum(early.screen_grayscale(), late.screen_grayscale()))


@each_level
def test_pooling_sees_every_pixel(level: SimdLevel) -> None:
    """One pixel differs, in either frame, at any column; it is in the result and in the changes."""
    table = np.arange(256, dtype=np.uint8)
    for column in range(160):
        for which in (0, 1):
            pair = np.full((2, 4, 160), 100, np.uint8)
            pair[which, 2, column] = 200
            for pools in (table, np.maximum.outer(table, table).ravel()):
                gray, changes = pool_gray(pair[0], pair[1], pools, level=level)
                assert np.array_equal(gray, pair.max(0))
                assert changes == [WHOLE_ROW, 0, 1 << column // 8, 1 << column // 8]


@each_level
@pytest.mark.parametrize("seed", range(5))
def test_pooling_of_noise(seed: int, level: SimdLevel) -> None:
    table = np.random.default_rng(seed).permutation(256).astype(np.uint8)
    early, late = noise(210, seed), few_grays(210, seed)
    gray, changes = pool_gray(early, late, table, level=level)
    assert np.array_equal(gray, np.maximum(table[early], table[late]))
    assert changes == [WHOLE_ROW] * 210


@each_level
@pytest.mark.parametrize("seed", range(5))
def test_pairs_of_noise(seed: int, level: SimdLevel) -> None:
    """A table in which the order of the two frames matters; some rows repeat, some have one colour."""
    rng = np.random.default_rng(seed)
    table = rng.integers(0, 256, 65536).astype(np.uint8)
    early, late = noise(210, seed)[np.arange(210) // 3], few_grays(210, seed)[np.arange(210) // 2]
    early[50:100] = rng.integers(0, 256, (50, 1))
    late[70:120] = rng.integers(0, 256, (50, 1))
    gray, changes = pool_gray(early, late, table, level=level)
    assert np.array_equal(gray, table[early.astype(int) * 256 + late])
    assert changes == changes_of(early, late)
    assert 0 in changes


@each_level
def test_a_row_marked_as_repeated_is_not_read(level: SimdLevel) -> None:
    frame = noise(210)
    changed = np.random.default_rng(3).integers(0, 2, 210)
    changed[0] = 1
    source = np.maximum.accumulate(np.where(changed, np.arange(210), 0))
    changes = (changed * WHOLE_ROW).tolist()
    assert np.array_equal(resize(frame, 84, 84, changes, level=level), opencv(frame[source], 84, 84))


@each_level
@pytest.mark.parametrize(("height", "width"), SIZES)
def test_only_columns_marked_as_changed_are_read(height: int, width: int, level: SimdLevel) -> None:
    """Noise; each row repeats some blocks of eight columns of the row above."""
    rng = np.random.default_rng(height + width)
    frame = noise(210)
    changed = rng.random((210, 20)) < rng.random((210, 1)) ** 2
    for row in range(1, 210):
        frame[row] = np.where(changed[row].repeat(8), frame[row], frame[row - 1])
    changes = [WHOLE_ROW, *(changed[1:] @ (1 << np.arange(20))).tolist()]
    assert np.array_equal(resize(frame, height, width, changes, level=level), opencv(frame, height, width))


def test_changes_are_checked() -> None:
    for changes in ([0] * 209, [WHOLE_ROW + 1] * 210):
        with pytest.raises(ValueError, match="`changes` has"):
            resize(noise(210), 84, 84, changes)


@pytest.mark.parametrize(("height", "width"), [(211, 84), (84, 161), (0, 84), (-1, 84), (84, 0), (84, -1)])
def test_sizes_that_are_not_served(height: int, width: int) -> None:
    with pytest.raises(ValueError, match=f"{height} x {width}: the height must be within 1..210, the width within 1"):
        resize(noise(210), height, width)


def test_shapes_are_checked() -> None:
    frame, table = noise(210), np.zeros(256, np.uint8)
    with pytest.raises(ValueError, match="same"):
        pool_gray(frame, frame[:209], table)
    with pytest.raises(ValueError, match="table of 256 or 65536"):
        pool_gray(frame, frame, table[:255])
    with pytest.raises(ValueError, match="each row"):
        resize(frame, 84, 84, np.zeros(209, np.uint8))
    with pytest.raises(ValueError, match="a frame of 301 x 160"):
        resize(noise(301), 84, 84)
    with pytest.raises(TypeError):
        resize(frame[:, :159].copy(), 84, 84)
