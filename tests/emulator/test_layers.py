"""Which folder of the emulator may include which. The machine, which is the reference core, includes only itself.

Each chip of the machine is a file that a reader understands without the other chips.
"""

import re
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "atari" / "emulator"
CLIENT = Path(__file__).parents[1] / "instructions"

# The folders whose files a folder's files may include, besides their own.
MACHINE = {"machine", "machine/cartridge", "machine/cpu", "machine/tia"}
FAST = MACHINE | {"fast", "fast/interpreter", "fast/jit", "fast/tia"}
ALE = FAST | {"ale", "ale/colours", "ale/programs"}
ALLOWED = {
    "machine": MACHINE,
    "machine/cartridge": {"machine"},
    "machine/cpu": {"machine"},
    "machine/tia": {"machine"},
    "fast": FAST,
    "fast/interpreter": FAST,
    "fast/jit": FAST,
    "fast/tia": MACHINE | {"fast"},
    "ale": ALE,
    "ale/colours": FAST,
    "ale/programs": MACHINE,
    "observations": ALE,
    "memory": set[str](),
    "vector": ALE | {"observations"},
    "lab": ALE | {"vector"},
    "python": ALE | {"observations", "vector", "memory", "lab"},
}


def sources() -> list[Path]:
    return sorted(file for file in SOURCES.rglob("*") if file.suffix in {".cpp", ".hpp", ".def"})


@pytest.mark.parametrize("file", sources(), ids=lambda file: str(file.relative_to(SOURCES)))
def test_a_file_includes_what_its_part_may(file: Path) -> None:
    here = str(file.parent.relative_to(SOURCES))
    for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', file.read_text(), re.MULTILINE):
        if (file.parent / name).exists():  # of the same folder
            continue
        assert (SOURCES / name).exists(), f"{file.name} includes {name}, which does not exist"
        there = str(Path(name).parent)
        assert there in ALLOWED[here], f"{here}/{file.name} includes {name} of {there}"


@pytest.mark.parametrize(
    ("file", "headers"),
    [
        (CLIENT / "play.cpp", ["game_words.hpp"]),
        (CLIENT / "game_words.hpp", ["ale/environment.hpp"]),
        (SOURCES / "ale" / "environment.hpp", []),
    ],
    ids=["play.cpp", "game_words.hpp", "environment.hpp"],
)
def test_a_client_that_only_plays_includes_one_header(file: Path, headers: list[str]) -> None:
    """`play.cpp` also asserts, when it is compiled, that the header shows neither the machine nor the console."""
    assert re.findall(r'^\s*#\s*include\s+"([^"]+)"', file.read_text(), re.MULTILINE) == headers


def test_every_folder_is_a_part() -> None:
    assert {str(file.parent.relative_to(SOURCES)) for file in sources()} == set(ALLOWED)


# The chips of the machine by their files, each with the chips that it uses.
CHIPS: dict[str, set[str]] = {
    "machine/cpu/cpu": set(),
    "machine/cpu/cpu_instructions": {"machine/cpu/cpu"},
    "machine/riot": set(),
    "machine/tia/sound": set(),
    "machine/tia/tia_renderer": set(),
    "machine/tia/tia": {"machine/tia/tia_renderer"},
    "machine/cartridge/dpc": set(),
    "machine/cartridge/bankswitching": {"machine/cartridge/dpc"},
}


def included(name: str, seen: set[str]) -> set[str]:
    """The names of all files of the machine that a file includes, directly or not."""
    for file in (SOURCES / f"{name}.hpp", SOURCES / f"{name}.cpp"):
        if not file.exists():
            continue
        for inner in re.findall(r'#include "([\w/]+)\.hpp"', file.read_text()):
            found = inner if "/" in inner else f"{Path(name).parent.as_posix()}/{inner}"
            if found not in seen:
                seen.add(found)
                included(found, seen)
    return seen


def test_every_chip_is_a_file() -> None:
    assert all((SOURCES / f"{chip}.hpp").exists() for chip in CHIPS)


@pytest.mark.parametrize("chip", CHIPS)
def test_a_chip_includes_no_other_chip(chip: str) -> None:
    others = (CHIPS.keys() | {"machine/console", "machine/state"}) - CHIPS[chip] - {chip}
    assert not included(chip, set()) & others
