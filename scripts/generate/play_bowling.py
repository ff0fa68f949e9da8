#!/usr/bin/env python
"""Plays Bowling for its page: tries each way to throw with snapshots, and takes the best one.

A throw is the bowler's place, the time before the ball curves, and the side to which it curves.
"""

import argparse
import sys
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
from plays import keep_best_ways

from atari.cores import NativeCore
from atari.lab import Ram

NOOP, FIRE, UP, DOWN = 0, 1, 2, 5
PINS = [f"pin_{pin}_state" for pin in range(10)]
LONGEST = 180
"""Decisions that a throw takes at most."""


def throw(core: NativeCore, way: tuple[int, int, int, int]) -> tuple[list[int], float]:
    """Stand, throw and curve. Return the actions until the ball is back, and the throw's quality."""
    side, steps, wait, curve = way
    ram = Ram(core)
    actions = [side] * steps + [NOOP] + [FIRE] * 8 + [NOOP] * wait + [curve] * 40
    actions += [NOOP] * (LONGEST - len(actions))
    played, reward, fallen = [], 0.0, 0
    for action in actions:
        reward += core.act(action)
        played.append(action)
        if ram["throw_state"] >= 5:
            fallen = max(fallen, sum(ram[pin] >= 250 for pin in PINS))
        elif len(played) > 60 and ram["throw_state"] == 0:
            break
    return played, reward + fallen - len(played) / 1000


def main() -> None:
    """Plan, throw by throw, and keep the play if it is better."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    ways = list(product((UP, DOWN), (0, 2, 4, 7, 10), (0, 4, 8, 14), (NOOP, UP, DOWN)))
    how = "A script with snapshots (scripts/generate/play_bowling.py): it tried every way to throw and took the best."
    print(keep_best_ways("bowling", ways, throw, how))


if __name__ == "__main__":
    main()
