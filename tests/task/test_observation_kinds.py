"""The table of observation types is complete, and no other module compares their names."""

import ast
from pathlib import Path
from typing import get_args

import pytest

from atari.task.observation_kinds import IN_WORDS, KINDS, ObsType, with_image

TOP = Path(__file__).parents[2]
DATA_SETS = {"atari/recording/minari.py", "atari/recording/episodes.py"}
"""The "dict" of a data set is `RamObservation` around the recorded image, whatever its colours are."""


def test_each_observation_type_has_a_row() -> None:
    assert tuple(KINDS) == get_args(ObsType)
    assert all(name in IN_WORDS for name in KINDS)


def test_an_image_is_found_by_its_colours_and_the_ram_beside_it() -> None:
    found = {(gray, ram): with_image(gray=gray, ram=ram) for gray in (True, False) for ram in (True, False)}
    assert found == {
        (True, True): "dict",
        (True, False): "grayscale",
        (False, True): "rgb_dict",
        (False, False): "rgb",
    }


def comparisons(text: str) -> list[str]:
    """The comparisons of an `obs_type` with the name of an observation type."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Compare):
            names = {part.value for part in ast.walk(node) if isinstance(part, ast.Constant)} & {*KINDS}
            sides = [ast.unparse(side).strip("()[]'") for side in (node.left, *node.comparators)]
            found += [ast.unparse(node)] * (bool(names) and any(side.endswith("obs_type") for side in sides))
    return found


@pytest.mark.parametrize(
    "line",
    [
        "task.obs_type == 'ram'",
        "obs_type in ('dict', 'rgb_dict')",
        "'rgb' != fields['obs_type']",
        "x.get('obs_type') == 'rgb'",
    ],
)
def test_a_comparison_is_found(line: str) -> None:
    assert comparisons(line)
    assert not comparisons("obs_type == 'image' or task.kind.image == 'rgb'")


def test_no_module_compares_the_names() -> None:
    paths = [path for part in ("atari", "wrappers", "roms", "scripts") for path in (TOP / part).rglob("*.py")]
    texts = {path.relative_to(TOP).as_posix(): path.read_text() for path in paths}
    found = {name: lines for name, text in texts.items() if "obs_type" in text and (lines := comparisons(text))}
    assert found.keys() == DATA_SETS, "ask `Task.kind`, a row of `atari.task.observation_kinds.KINDS`"
