"""Random programs, frame by frame, against ale-py: RAM, audio and screen.

`facts/programs.json` has the check sums of what ale-py plays, and the rows of its screens: ale-py is slow, and its answers
do not change. A program that differs from them is played by ale-py again, as is one program of each kind in any case.
`PYTHONPATH=tests python tests/emulator/test_random_programs.py` writes the file anew, from ale-py alone.

The screens of programs for the processor are not compared. These programs end frames in the middle of visible lines,
where ale-py may show up to three pixels after the beam. The emulator does not imitate that.
"""

import json
import random
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from emulator import wild_programs
from emulator.machines import FACTS, emulator, game_of
from emulator.programs import cpu_program, tia_program
from emulator.reference import GAME

from atari.games.catalog import games
from atari.games.compiler import compile_rules

REFERENCE = Path(__file__).with_name("reference.py")
ANSWERS = FACTS / "programs.json"


class Program(NamedTuple):
    """An image, and actions; -1 is a reset."""

    name: str
    image: bytes
    actions: list[int]


def random_programs(make: Any, batches: Iterable[int]) -> list[Program]:
    found = []
    for seed in (1000 * batch + number for batch in batches for number in range(15)):
        rng = random.Random(seed)
        actions = [rng.randrange(18) for _ in range(8)]
        actions[4] = -1
        found.append(Program(f"{make.__name__} {seed}", make(rng), actions))
    return found


def in_tia_space(make: Any, *seeds: int) -> list[Program]:
    """Where a frame begins there, the first opcode is the byte of RAM that ALE has read last."""
    found = []
    for seed in seeds:
        rng = random.Random(seed)
        image = make(rng, "4K")
        actions = [-1 if k % 4 == 0 else rng.randrange(18) for k in range(12)]
        found.append(Program(f"{make.__name__} {seed}", image, actions))
    return found


SOUP = (5, 26, 42, 51, 70, 80, 96, 105, 120, 142, 154, 165, 183, 190, 192, 216, 219, 234)
PROGRAMS = {
    "tia": random_programs(tia_program, (batch for batch in range(12) if batch % 3 != 2)),
    "cpu": random_programs(cpu_program, range(2, 12, 3)),
    "soup": in_tia_space(wild_programs.soup, *SOUP),
    "noise": in_tia_space(wild_programs.noise, 38, 90, 95, 135, 223, 244),
    "frames that end in a blanked line": [
        Program(f"{look.hex()}, {wait}", wild_programs.blank_ends(look, wait), [0] * 8)
        for look in wild_programs.BLANKED_LOOKS
        for wait in (0, 9, 25)
    ],
    "latches fetched as code right after a store": [
        Program(end.hex(), wild_programs.runs_into_tia_space(end), [0] * 120)
        for end in wild_programs.STORES_BEFORE_TIA_SPACE
    ],
}
COMPARED = {"tia": ("ram", "audio", "screen"), "frames that end in a blanked line": ("ram", "screen")}
"""The arrays of a kind that are compared, if they are not RAM and audio."""


def played_by_ale_py(programs: list[Program]) -> list[dict[str, Any]]:
    """The arrays of each program by their names, played in one process of ale-py."""
    with tempfile.TemporaryDirectory() as folder:
        script, result = Path(folder, "script.json"), Path(folder, "result.npz")
        script.write_text(
            json.dumps([{"image": program.image.hex(), "actions": program.actions} for program in programs])
        )
        command = [sys.executable, str(REFERENCE), str(script), str(result)]
        child = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert child.returncode == 0, child.stderr
        arrays = np.load(result)
        names = ("ram", "audio", "screen")
        return [{name: arrays[f"{number} {name}"] for name in names} for number in range(len(programs))]


def played_by_us(program: Program, rows: int, names: tuple[str, ...]) -> dict[str, Any]:
    """The same of our emulator, with the rules under which ale-py plays the image, and the format that it detected."""
    rules_of_game = games[GAME].rules
    assert rules_of_game is not None
    ours = emulator(game_of(program.image, compile_rules(rules_of_game), rows=rows))
    seen: dict[str, list[Any]] = {name: [] for name in names}
    for action in [None, *program.actions]:
        if action == -1:
            ours.reset()
        elif action is not None:
            ours.act(action)
        for name in names:
            seen[name].append(getattr(ours, name)())
    return {name: np.stack(arrays) for name, arrays in seen.items()}


def answer(arrays: dict[str, Any], names: tuple[str, ...], rows: int) -> list[int]:
    """The rows of ale-py's screens, and the check sum of the compared arrays."""
    crc = 0
    for name in names:
        crc = zlib.crc32(arrays[name].tobytes(), crc)
    return [rows, crc]


@pytest.mark.parametrize("kind", PROGRAMS)
def test_equal_to_ale_py(kind: str) -> None:
    names = COMPARED.get(kind, ("ram", "audio"))
    answers = json.loads(ANSWERS.read_text())[kind]
    assert list(answers) == [program.name for program in PROGRAMS[kind]]
    doubtful = PROGRAMS[kind][:1]
    for program in PROGRAMS[kind]:
        rows = answers[program.name][0]
        if answer(played_by_us(program, rows, names), names, rows) != answers[program.name]:
            doubtful.append(program)
    for program, theirs in zip(doubtful, played_by_ale_py(doubtful), strict=True):
        rows = theirs["screen"].shape[1]
        assert answer(theirs, names, rows) == answers[program.name], f"{program.name}: write facts/programs.json anew"
        for name, array in played_by_us(program, rows, names).items():
            for frame, (ours, expected) in enumerate(zip(array, theirs[name], strict=True)):
                np.testing.assert_array_equal(ours, expected, err_msg=f"{program.name}, frame {frame}: {name}")


if __name__ == "__main__":
    found: dict[str, dict[str, list[int]]] = {}
    for kind, programs in PROGRAMS.items():
        names = COMPARED.get(kind, ("ram", "audio"))
        found[kind] = {}
        for start in range(0, len(programs), 15):
            some = programs[start : start + 15]
            for program, arrays in zip(some, played_by_ale_py(some), strict=True):
                found[kind][program.name] = answer(arrays, names, arrays["screen"].shape[1])
    lines = [f'"{kind}": {json.dumps(answers)}' for kind, answers in found.items()]
    ANSWERS.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
