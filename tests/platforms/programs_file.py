"""Writes random programs and the cartridges of all games as the text that the program `fast_equals_plain` reads.

The programs are those of tests/emulator/test_fast_equals_plain.py, with other seeds. The text is not part of the
repository: it contains the ROM images of the installed ale-py.
"""

import argparse
import random
import sys
from collections.abc import Iterator
from pathlib import Path

import atari
from atari.roms import find

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from emulator import wild_programs
from emulator.programs import cpu_program, tia_program

OF_A_KIND = (wild_programs.noise, wild_programs.soup)
WITHOUT = (
    wild_programs.changing_frames, wild_programs.nearly_still, wild_programs.glances, wild_programs.starfield,
    wild_programs.short_frames, wild_programs.glances_at_blanks, wild_programs.waiting, wild_programs.entered_anywhere,
    tia_program, cpu_program,
)  # fmt: skip


def programs(seeds: int) -> Iterator[tuple[str, str, bytes]]:
    """A name, a cartridge type and an image."""
    for seed in range(1000, 1000 + seeds):
        for make in OF_A_KIND:
            for kind in wild_programs.SIZES:
                yield f"{make.__name__} {kind} {seed}", kind, make(random.Random(seed), kind)
        for make_4k in WITHOUT:
            yield f"{make_4k.__name__} {seed}", "4K", make_4k(random.Random(seed))
    for name, game in atari.games.items():
        yield name, game.rom.cartridge, find(name).read_bytes()


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("output", type=Path)
    parser.add_argument("--seeds", type=int, default=20, metavar="N", help="programs of each sort (default 20)")
    options = parser.parse_args()
    count = 0
    with options.output.open("w") as file:
        for count, (name, kind, image) in enumerate(programs(options.seeds), 1):
            file.write(f"name {name}\nseed {count}\ncartridge {kind}\nimage {image.hex()}\n\n")
    print(f"{count} programs in {options.output}")


if __name__ == "__main__":
    main()
