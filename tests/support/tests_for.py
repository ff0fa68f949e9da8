#!/usr/bin/env python3
"""Prints which tests concern a changed file: a line of pytest's arguments for each run, the nearest tests first.

The tests mirror the sources: the tests of `atari/vector/results.py` are `tests/vector/test_results.py`, then all of
`tests/vector`. `PLACES` has the files without a mirror. `scripts/dev test` and `scripts/mutants` use this.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Iterator
from functools import cache
from itertools import zip_longest
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]

PLACES: dict[str, tuple[str, ...]] = {
    "atari/emulator/machine": ("tests/emulator", "tests/conformance/test_goldens.py"),
    "atari/emulator/fast": (
        "tests/emulator/test_fast_equals_plain.py",
        "tests/emulator",
        "tests/conformance/test_goldens.py",
    ),
    "atari/emulator/ale": (
        "tests/cores",
        "tests/games",
        "tests/multiplayer",
        "tests/conformance/test_goldens.py",
    ),
    "atari/emulator/ale/colours": (
        "tests/conformance/test_native_equals_ale_py.py",
        "tests/emulator/test_observation.py",
    ),
    "atari/emulator/ale/programs": ("tests/games", "tests/lab", "tests/cores", "tests/conformance/test_goldens.py"),
    "atari/emulator/observations": ("tests/emulator/test_observation.py", "tests/wrappers", "tests/vector"),
    "atari/emulator/vector": ("tests/vector", "tests/multiplayer/test_vector.py"),
    "atari/emulator/memory": ("tests/learning/memory",),
    "atari/emulator/lab": ("tests/lab/test_causes.py",),
    "atari/emulator/python/binding_memory.cpp": ("tests/learning/memory",),
    "atari/emulator/python/binding_causes.cpp": ("tests/lab/test_causes.py",),
    "atari/emulator/python/binding_labels.cpp": ("tests/lab",),
    "atari/emulator/python/binding_reward.cpp": ("tests/wrappers/test_expression_reward.py", "tests/vector"),
    "atari/emulator/python/binding_writes.cpp": ("tests/lab",),
    "atari/emulator/python": ("tests/cores", "tests/vector"),
    "atari/cores/compiled.py": ("tests/cores", "tests/games/test_rewards.py", "tests/multiplayer"),
    "atari/env/env.py": ("tests/conformance/test_ale_goldens.py", "tests/conformance/test_env_equals_ale_py.py"),
    "atari/env/driver.py": ("tests/env/test_env.py", "tests/env/test_env_observers.py", "tests/wrappers"),
    "atari/env/state.py": ("tests/env/test_env_snapshots.py", "tests/env/test_env.py"),
    "atari/registry/registration.py": (
        "tests/conformance/test_ids.py",
        "tests/games/test_own_games.py",
        "tests/vector",
    ),
    "atari/base/validation.py": ("tests/env/test_env.py", "tests/cores", "tests/wrappers", "tests/vector"),
    "atari/games/interventions": ("tests/lab",),
    "atari/games": ("tests/games", "tests/conformance/test_ale_goldens.py"),
    "atari/task/arguments.py": ("tests/task", "tests/cli/test_names_of_games.py"),
    "atari/learning/frame_episode.py": ("tests/learning/test_frame_agent.py", "tests/play/test_player_agent.py"),
    "atari/learning/programs.py": ("tests/learning/test_agent_code.py",),
    "atari/learning/agent.py": ("tests/learning/test_agent_code.py",),
    "atari/learning/training.py": ("tests/learning/test_agents.py",),
    "atari/cli/sweep.py": ("tests/learning/sweep/test_sweeps.py",),
    "atari/policy/__init__.py": ("tests/learning/test_policies.py", "tests/testing/test_policy.py"),
    "atari/policy/choice.py": ("tests/lab/test_dataset_check.py",),
    "atari/policy/watched.py": ("tests/learning/diagnosis/test_plays.py",),
    "atari/policy/needs.py": ("tests/learning/evaluation", "tests/testing/test_policy.py"),
    "atari/env/settings.py": (
        "tests/vector/test_tasks.py",
        "tests/learning/test_frame_agent.py",
        "tests/play/test_player_agent.py",
    ),
    "atari/env/episode_env.py": ("tests/env/test_episode_env.py", "tests/vector/test_tasks.py"),
    "atari/env/restorable.py": ("tests/wrappers/test_snapshots.py",),
    "atari/task/env_ids.py": (
        "tests/conformance/test_ids.py",
        "tests/registry/test_registration.py",
        "tests/vector/test_registration.py",
    ),
    "atari/registry/making.py": (
        "tests/registry/test_registration.py",
        "tests/vector/test_registration.py",
        "tests/task",
    ),
    "atari/task": ("tests/task", "tests/vector/test_tasks.py", "tests/wrappers/test_presets.py"),
    "wrappers/layers.py": ("tests/wrappers/test_layers.py", "tests/vector/test_tasks.py"),
    "atari/sb3.py": ("tests/integrations",),
    "atari/__init__.py": ("tests/test_import.py", "tests/cli/test_main.py"),
    "atari/base/program.py": ("tests/cli/test_streams.py", "tests/learning/test_commands.py", "tests/cli"),
    "atari/base/start.py": ("tests/cli/test_streams.py", "tests/base/test_variables.py"),
    "atari/base/variables.py": ("tests/base/test_variables.py",),
    "atari/base/progress.py": ("tests/cli/test_streams.py",),
    "atari/__main__.py": ("tests/cli/test_main.py",),
    "scripts/agents": ("tests/agents",),
    "scripts/bench": ("tests/test_bench.py",),
    "scripts/site": ("tests/site",),
    "scripts": ("tests/test_scripts.py",),
    "web": ("tests/web",),
    "docs": ("tests/test_documented_places.py",),
    "CONTRIBUTING.md": ("tests/test_documented_places.py",),
    "examples/self_play.py": ("tests/learning/test_self_play.py",),
    "examples": ("tests/base/test_notebook.py",),
}
"""By file or folder, its tests where they are not in the folder of the same name; the longest name counts."""

_LANES = {"peers", "distributed", "compiled", "browser", "gpu"}

GAME_FILE = re.compile(r"atari/games/(?:data|manuals|interventions/data)/(\w+)\.toml")
DOCUMENT = re.compile(r"(?:README|CONTRIBUTING|atari/games/SCHEMA|docs/\w[\w-]*)\.md")


def runs(file: str) -> list[list[str]]:
    """The runs of pytest for a file, named from the top of the repository: the arguments of each, nearest first.

    Raises:
        ValueError: no test concerns the file.
    """
    game = GAME_FILE.fullmatch(file)
    if game:
        return [["tests/games", "-k", game[1]], ["tests/conformance", "-k", game[1]]]
    if file.startswith("tests/"):
        return _runs_of_test_file(file)
    near, around = [*_mirrors(file)] or [*_importers(file)], [*_around(file)]
    if not near and around and around[0].endswith(".py"):
        near = [around[0]]
    if DOCUMENT.fullmatch(file):
        near.insert(0, file)
    if not near and not around:
        raise ValueError(
            f"no test concerns {file}; name the tests, or enter the file into PLACES of tests/support/tests_for.py"
        )
    return [each for each in (list(dict.fromkeys(near)), around) if each]


def _runs_of_test_file(file: str) -> list[list[str]]:
    """A test file itself; for a file that tests share, the tests that use it, or else its folder."""
    path = Path(file)
    if path.name.startswith("test_"):
        return [[file]]
    name = re.compile(rf"\b{re.escape(path.stem)}\b")
    tests = (TOP / "tests" if path.parent.name == "support" else (TOP / path).parent).rglob("test_*.py")
    users = sorted(test.relative_to(TOP).as_posix() for test in tests if name.search(test.read_text(encoding="utf-8")))
    return [users or [path.parent.as_posix()]]


def _mirrors(file: str) -> Iterator[str]:
    """The test files that are named like the file, in the part's folder."""
    path = Path(file)
    for folder in [*_folders(path), *(place for place in _around(file) if (TOP / place).is_dir())]:
        everywhere = "" if folder == "tests" else "**/"
        found = sorted((TOP / folder).glob(f"{everywhere}test_{path.stem.strip('_')}*.py"))
        if found:
            yield from (test.relative_to(TOP).as_posix() for test in found)
            return


def _importers(file: str) -> Iterator[str]:
    """The test files that import a module by its own name, at most five."""
    path = Path(file)
    if path.suffix != ".py" or path.stem.startswith("__"):
        return
    package = ".".join(path.parts[:-1]) if path.parts[0] == "atari" else f"atari.{'.'.join(path.parts[:-1])}"
    pattern = re.compile(rf"from {package}\.{path.stem} import|from {package} import [^\n]*\b{path.stem}\b")
    yield from [test for test, text in _plain_tests() if pattern.search(text)][:5]


@cache
def _plain_tests() -> list[tuple[str, str]]:
    """The names and texts of the test files that need no other packages."""
    files = [file for file in sorted((TOP / "tests").rglob("test_*.py")) if not _LANES & set(file.parts)]
    return [(file.relative_to(TOP).as_posix(), file.read_text(encoding="utf-8")) for file in files]


def _around(file: str) -> tuple[str, ...]:
    """The tests of the part that a file is in."""
    for place in sorted(PLACES, key=len, reverse=True):
        if file == place or file.startswith(f"{place}/"):
            return PLACES[place]
    return tuple(folder for folder in _folders(Path(file))[:1] if folder != "tests")


def _folders(path: Path) -> list[str]:
    """The folders of tests that mirror a file's folder, the deepest first."""
    parts = path.parts[1:-1] if path.parts[0] == "atari" else path.parts[:-1]
    names = ["/".join(["tests", *parts[:count]]) for count in range(len(parts), -1, -1)]
    return [name for name in names if (TOP / name).is_dir()]


def merged(files: list[str]) -> list[list[str]]:
    """The runs of several files: the nearest tests of all of them, then the others; each test once.

    Raises:
        ValueError: no test concerns one of the files.
    """
    levels = [[run for run in level if run] for level in zip_longest(*map(runs, files))]
    found: list[list[str]] = []
    for level in levels:
        plain = dict.fromkeys(test for run in level if "-k" not in run for test in run)
        found += [[*plain]] if plain else []
        found += [run for run in level if "-k" in run and run not in found]
    return found


def main() -> None:
    """Print the runs of the files that the command line names."""
    parser = argparse.ArgumentParser(
        description="Print which tests concern a file: a line of pytest's arguments a run."
    )
    parser.add_argument("file", nargs="+", help="a file of the repository, named from its top")
    try:
        found = merged(parser.parse_args().file)
    except ValueError as error:
        sys.exit(f"tests_for.py: {error}")
    for run in found:
        print(*run)


if __name__ == "__main__":
    main()
