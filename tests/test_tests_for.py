"""`tests/support/tests_for.py` finds tests for every file of the product, and the nearest ones first."""

import sys
from pathlib import Path

import pytest
import tests_for

TOP = Path(__file__).parent.parent


@pytest.mark.parametrize(
    ("file", "runs"),
    [
        ("atari/vector/results.py", [["tests/vector/test_results.py"], ["tests/vector"]]),
        ("wrappers/clip_reward.py", [["tests/wrappers/test_clip_reward.py"], ["tests/wrappers"]]),
        (
            "atari/env/env.py",
            [
                [
                    "tests/env/test_env.py",
                    "tests/env/test_env_assigned_ale.py",
                    "tests/env/test_env_hooks.py",
                    "tests/env/test_env_observers.py",
                    "tests/env/test_env_snapshots.py",
                ],
                ["tests/conformance/test_ale_goldens.py"],
            ],
        ),
        ("atari/emulator/vector/engine.cpp", [["tests/vector/test_engine_misuse.py"], ["tests/vector"]]),
        ("atari/emulator/fast/fast_console.cpp", [["tests/emulator/test_fast_equals_plain.py"], []]),
        ("atari/emulator/memory/sampling.cpp", [["tests/learning/memory"]]),
        ("atari/games/data/pong.toml", [["tests/games", "-k", "pong"], ["tests/conformance", "-k", "pong"]]),
        ("tests/vector/test_ends.py", [["tests/vector/test_ends.py"]]),
        ("docs/learning.md", [["docs/learning.md"], ["tests/test_documented_places.py"]]),
    ],
)
def test_tests_of_a_file(file: str, runs: list[list[str]]) -> None:
    found = tests_for.runs(file)
    assert len(found) == len(runs)
    for names, expected in zip(found, runs, strict=True):
        assert names[: len(expected)] == expected


def product() -> list[str]:
    folders = ["atari", "wrappers", "roms"]
    files = [
        file for folder in folders for suffix in ("py", "cpp", "hpp") for file in (TOP / folder).rglob(f"*.{suffix}")
    ]
    return sorted(file.relative_to(TOP).as_posix() for file in files)


def test_every_file_of_the_product_has_tests() -> None:
    for file in product():
        for test in (name for run in tests_for.runs(file) for name in run):
            assert (TOP / test).exists(), f"{file}: {test} does not exist"


def test_the_nearest_tests_of_several_files_come_first() -> None:
    assert tests_for.merged(["atari/vector/results.py", "wrappers/clip_reward.py"])[-1] == [
        "tests/vector",
        "tests/wrappers",
    ]


def test_a_file_without_tests_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match=r"no test concerns nowhere/a\.xyz"):
        tests_for.runs("nowhere/a.xyz")
    monkeypatch.setattr(sys, "argv", ["tests_for.py", "nowhere/a.xyz"])
    with pytest.raises(SystemExit, match=r"^tests_for\.py: no test concerns"):
        tests_for.main()
