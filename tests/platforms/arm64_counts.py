"""Counts the instructions a frame of the native core on arm64, translated and by handlers, beside x86-64's.

QEMU counts on arm64, by a plugin (tests/instructions/qemu_counter.cpp), and valgrind on x86-64. Both run the program
`play` as tests/instructions/counting.py does. A count says nothing about seconds: processors differ in what an
instruction costs. `scripts/platforms arm64-counts` builds the programs and runs this file.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import atari

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "instructions"))
from counting import GAMES, LONG, SHORT, instructions_in
from game_words import game_words

MOST = 1.3
"""Translated code of arm64 takes at most this many times the instructions of x86-64."""


def count(command: list[str], game: Path, translated: bool) -> int:
    """Instructions a frame."""
    totals = []
    for frames in (SHORT, LONG):
        environment = {**os.environ, "ATARI_JIT": "1" if translated else "0"}
        done = subprocess.run(
            [*command, str(game), str(frames), "nothing"],
            env=environment,
            text=True,
            capture_output=True,
            check=True,
        )
        collected = done.stderr.replace("Collected :", "\ntotals:")  # valgrind's words
        totals.append(instructions_in(collected))
    return round((totals[1] - totals[0]) / (LONG - SHORT))


def main() -> int:
    """Count, and compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("x86", type=Path, help="`play` of this machine")
    parser.add_argument("arm64", type=Path, help="`play` of arm64")
    parser.add_argument("plugin", type=Path, help="the plugin of QEMU")
    options = parser.parse_args()
    x86 = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(options.x86)]
    arm64 = ["qemu-aarch64", "-plugin", str(options.plugin.resolve()), str(options.arm64)]
    print(f"{'instructions a frame':22}{'x86-64':>9}{'arm64':>9}{'ratio':>7}{'handlers':>10}{'ratio':>7}")
    most = 0.0
    for name in GAMES:
        game = options.arm64.with_name(f"{name}.game")
        game.write_text(game_words(atari.games.find(name)))
        here, there, handlers = count(x86, game, True), count(arm64, game, True), count(arm64, game, False)
        print(f"{name:22}{here:>9}{there:>9}{there / here:>7.2f}{handlers:>10}{there / handlers:>7.2f}", flush=True)
        most = max(most, there / here)
    print(f"At most {most:.2f} times the instructions of x86-64; {MOST} are allowed.")
    return 0 if most <= MOST else 1


if __name__ == "__main__":
    sys.exit(main())
