"""Which folder of the emulator may include which. The machine, which is the reference core, includes only itself."""

import re
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2] / "atari" / "emulator"
CLIENT = Path(__file__).parents[1] / "instructions" / "play.cpp"

# The folders whose files a folder's files may include, besides their own.
FAST = {"machine", "fast", "fast/interpreter", "fast/jit", "fast/tia"}
ALLOWED = {
    "machine": set[str](),
    "fast": FAST,
    "fast/interpreter": FAST,
    "fast/jit": FAST,
    "fast/tia": {"machine", "fast"},
    "ale": FAST,
    "observations": FAST | {"ale"},
    "memory": set[str](),
    "vector": FAST | {"ale", "observations"},
    "lab": FAST | {"ale", "vector"},
    "python": FAST | {"ale", "observations", "vector", "memory", "lab"},
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


@pytest.mark.parametrize("file", [SOURCES / "ale" / "environment.hpp", CLIENT], ids=lambda file: file.name)
def test_a_client_that_only_plays_includes_one_header(file: Path) -> None:
    """`play.cpp` also asserts, when it is compiled, that the header shows neither the machine nor the console."""
    included = re.findall(r'^\s*#\s*include\s+"([^"]+)"', file.read_text(), re.MULTILINE)
    assert included == (["ale/environment.hpp"] if file == CLIENT else [])


def test_every_folder_is_a_part() -> None:
    assert {str(file.parent.relative_to(SOURCES)) for file in sources()} == set(ALLOWED)
