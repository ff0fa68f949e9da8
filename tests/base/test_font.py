"""The font of captions and pictures."""

import numpy as np
import pytest

from atari.base import font

PRINTABLE = "".join(map(chr, range(32, 127)))


def test_each_character_has_a_glyph_of_its_own() -> None:
    cells = np.split(font.line(PRINTABLE), len(PRINTABLE), axis=1)
    assert len({cell.tobytes() for cell in cells}) == 95
    assert [cell.any() for cell in cells] == [False] + [True] * 94
    assert not any(cell[:, -1].any() for cell in cells), "characters would touch"


def test_a_glyph() -> None:
    rows = ["".join(".#"[pixel] for pixel in row) for row in font.line("Ag").astype(int)]
    assert rows == [
        ".###........",
        "#...#.......",
        "#...#..####.",
        "#####.#...#.",
        "#...#.#...#.",
        "#...#..####.",
        "#...#.....#.",
        ".......###..",
    ]


@pytest.mark.parametrize("scale", [1, 2, 5])
def test_a_scale_repeats_pixels(scale: int) -> None:
    assert np.array_equal(font.line("x = 7", scale), font.line("x = 7").repeat(scale, 0).repeat(scale, 1))


def test_other_characters() -> None:
    assert np.array_equal(font.line("é\ud800\U0001f600"), font.line("???"))
    assert not font.line("\0\t\x7f").any()
    assert font.line("").shape == (8, 0)


def test_writing_keeps_the_background_and_to_the_image() -> None:
    image = np.full((20, 40, 3), 9, np.uint8)
    font.write(image, "a long line", 10, 4, (1, 2, 3), 1)
    expected = np.full((20, 40, 3), 9, np.uint8)
    expected[4:12, 10:40][font.line("a lon")] = (1, 2, 3)
    assert np.array_equal(image, expected)
    for left in (40, 100):
        font.write(image, "outside", left, 4, (1, 2, 3))
    assert np.array_equal(image, expected)
