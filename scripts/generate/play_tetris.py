#!/usr/bin/env python
"""Plays Tetris for its page: tries each place for the falling piece with snapshots, and takes the best board.

A board is better the more rows it clears, and the lower, smoother and freer of holes it is (after Dellacherie). RAM:
byte r has columns 4..0 of row r from the bottom, byte 22 + r columns 5..9.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
from plays import keep_best_ways

from atari.cores import NativeCore

ROWS, STORED = 18, 22
PIECE_ROW = 105
NOOP, FIRE, RIGHT, LEFT, DOWN = (0, 1, 3, 4, 5)


def board(core: NativeCore) -> npt.NDArray[np.bool_]:
    """The cells, (rows from the bottom, 10 columns)."""
    ram = core.ram()
    bits = np.arange(5)
    left, right = ram[:ROWS, None] >> bits[::-1] & 1, ram[STORED : STORED + ROWS, None] >> bits & 1
    return np.hstack([left, right]).astype(bool)


def quality(cells: npt.NDArray[np.bool_]) -> float:
    """The quality of a board, from its heights, holes and steps between columns."""
    heights = np.where(cells.any(0), ROWS - cells[::-1].argmax(0), 0)
    holes = heights.sum() - cells.sum()
    return float(-0.5 * heights.sum() - 4.0 * holes - 0.7 * abs(np.diff(heights)).sum() - 0.02 * (heights**2).sum())


def drop(core: NativeCore, actions: list[int]) -> tuple[list[int], float]:
    """Play the actions and then let the piece fall. Return all actions, and the quality of the board with rewards."""
    played, rewards = [], 0.0
    for action in actions:
        rewards += core.act(action)
        played.append(action)
    while len(played) < 120 and not core.game_over:
        before = int(core.ram()[PIECE_ROW])
        rewards += core.act(DOWN)
        played.append(DOWN)
        if abs(int(core.ram()[PIECE_ROW]) - before) > 4:  # the next piece
            break
    return played, quality(board(core)) + rewards - 1000 * core.game_over


def main() -> None:
    """Plan, piece by piece, and keep the play if it is better."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    places = [
        [FIRE, NOOP] * turns + [way, NOOP] * steps for turns in range(4) for way in (LEFT, RIGHT) for steps in range(7)
    ]
    how = (
        "A script with snapshots (scripts/generate/play_tetris.py): "
        "it tried every place for the piece and took the best board."
    )
    print(keep_best_ways("tetris", places, drop, how))


if __name__ == "__main__":
    main()
