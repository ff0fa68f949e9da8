#!/usr/bin/env python
"""Measures frames a second beside ale-py, in five seconds: one core, random actions, with and without pictures.

    scripts/bench/quick.py [GAME]

`scripts/bench.py` has whole comparisons.
"""

import argparse
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # PYTHONSAFEPATH leaves it out
from comparison import Run
from suites import ale_py_frames, core_frames

SECONDS = 1.2
"""Seconds of each of four measurements, in turns of a tenth."""


def speeds(game: str, sides: list[Callable[[str], Run]]) -> list[float]:
    """Frames a second of each side, which play in turns."""
    runs = [side(game) for side in sides]
    frames, seconds = [0] * len(runs), [1e-9] * len(runs)
    for run in runs:
        run(100)  # the first frames are slower
    while min(seconds) < SECONDS:
        for number, run in enumerate(runs):
            count = max(100, int(SECONDS / 10 * frames[number] / seconds[number]))
            seconds[number] += run(count)
            frames[number] += count
    return [frames[number] / seconds[number] for number in range(len(runs))]


def main() -> None:
    """Print both comparisons."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("game", nargs="?", default="breakout", help="a game of ale-py (default: breakout)")
    game = parser.parse_args().game
    print(f"{'frames a second of ' + game:34} {'atari-envs':>12} {'ale-py':>12}")
    for name, rgb in (("without pictures", False), ("with a picture (RGB) of each", True)):
        ours, theirs = speeds(game, [partial(core_frames, rgb=rgb), partial(ale_py_frames, rgb=rgb)])
        print(f"{name:34} {ours:12,.0f} {theirs:12,.0f}   {ours / theirs:.1f} times as fast")


if __name__ == "__main__":
    main()
