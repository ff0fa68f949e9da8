"""Random programs, frame by frame, against ale-py: RAM, audio and screen.

The screens of programs for the processor are not compared. These programs end frames in the middle of visible lines,
where ale-py may show up to three pixels after the beam. The emulator does not imitate that.
"""

import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from emulator import wild_programs
from emulator.programs import cpu_program, tia_program
from emulator.reference import GAME

import atari._emulator as _emulator
from atari.games.catalog import games
from atari.games.compiler import compile_rules

BATCH = 15  # programs in one process of ale-py
REFERENCE = Path(__file__).with_name("reference.py")


def reference(entries: list[dict[str, Any]], folder: Path) -> Any:
    """The results of ale-py for the programs."""
    script, result = folder / "script.json", folder / "result.npz"
    script.write_text(json.dumps(entries))
    child = subprocess.run(
        [sys.executable, str(REFERENCE), str(script), str(result)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert child.returncode == 0, child.stderr
    return np.load(result)


def emulator(image: bytes, rows: int) -> _emulator.Emulator:
    """Our emulator, with the rules under which ale-py plays the image, and with the format that ale-py detected."""
    rules_of_game = games[GAME].rules
    assert rules_of_game is not None
    rules = compile_rules(rules_of_game)
    game = _emulator.make_game(
        image=image, cartridge="", format="PAL" if rows == 250 else "NTSC", detect_format=True, first_line=34, height=rows,
        hmove_blanks=True, paddles=(False, False), swap_ports=False, swap_paddles=False, paddle_range=(27450, 790196),
        power_on_switches=0x3F, legal_actions=list(range(18)), starting_actions=[], default_mode=0,
        variables=rules.variables, initial=rules.initial, kept=rules.kept, outputs=rules.outputs, step=rules.step,
        select_mode=rules.select_mode,
    )  # fmt: skip
    return _emulator.Emulator(
        game=game, repeat_action_probability=0.0, frame_skip=1, max_num_frames_per_episode=0, sound=True,
        color_averaging=False, seed=1,
    )  # fmt: skip


Program = tuple[str, bytes, list[int]]
"""A name, an image, and actions; -1 is a reset."""


def compare(programs: list[Program], names: tuple[str, ...], folder: Path) -> None:
    """Runs all programs in one process of ale-py, and by our emulator."""
    expected = reference([{"image": image.hex(), "actions": actions} for _, image, actions in programs], folder)
    for number, (program, image, actions) in enumerate(programs):
        rows = expected[f"{number} screen"].shape[1]
        ours = emulator(image, rows)
        for frame, action in enumerate([None, *actions]):
            if action == -1:
                ours.reset()
            elif action is not None:
                ours.act(action)
            for name in names:
                what = f"{program}, frame {frame}: {name}"
                np.testing.assert_array_equal(getattr(ours, name)(), expected[f"{number} {name}"][frame], err_msg=what)


@pytest.mark.parametrize("batch", range(12))
def test_equal_to_ale_py(batch: int, tmp_path: Path) -> None:
    """Two thirds of the programs exercise the TIA, one third the processor."""
    make = cpu_program if batch % 3 == 2 else tia_program
    programs: list[Program] = []
    for number in range(BATCH):
        rng = random.Random(1000 * batch + number)
        actions = [rng.randrange(18) for _ in range(8)]
        actions[4] = -1
        programs.append((f"{make.__name__} {number} of batch {batch}", make(rng), actions))
    compare(programs, ("ram", "audio") if make is cpu_program else ("ram", "audio", "screen"), tmp_path)


@pytest.mark.parametrize(
    ("make", "seeds"),
    [
        (wild_programs.soup, (5, 26, 42, 51, 70, 80, 96, 105, 120, 142, 154, 165, 183, 190, 192, 216, 219, 234)),
        (wild_programs.noise, (38, 90, 95, 135, 223, 244)),
    ],
)
def test_programs_that_run_in_tia_space(make: Any, seeds: tuple[int, ...], tmp_path: Path) -> None:
    """Where a frame begins there, the first opcode is the byte of RAM that ALE has read last."""
    programs: list[Program] = []
    for seed in seeds:
        rng = random.Random(seed)
        image = make(rng, "4K")
        actions = [-1 if k % 4 == 0 else rng.randrange(18) for k in range(12)]
        programs.append((f"{make.__name__} {seed}", image, actions))
    compare(programs, ("ram", "audio"), tmp_path)


def test_frames_that_end_in_a_blanked_line(tmp_path: Path) -> None:
    programs: list[Program] = []
    for look in wild_programs.BLANKED_LOOKS:
        programs += [(f"{look.hex()}, {wait}", wild_programs.blank_ends(look, wait), [0] * 8) for wait in (0, 9, 25)]
    compare(programs, ("ram", "screen"), tmp_path)


def test_latches_fetched_as_code_right_after_a_store(tmp_path: Path) -> None:
    programs: list[Program] = []
    for end in wild_programs.STORES_BEFORE_TIA_SPACE:
        programs.append((end.hex(), wild_programs.runs_into_tia_space(end), [0] * 120))
    compare(programs, ("ram",), tmp_path)
