"""Bare consoles for the tests of the chips, and the tables they are compared with.

`facts/` holds measurements of ale-py 0.12.1: the opcodes, the reactions of the TIA, check sums. The models
(`model_6502`, `model_tia`) are written from the same description as the emulator, but independently and as simply as
possible.
"""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from atari_inspection import Console

import atari._emulator as _emulator
from atari.games.compiler import CompiledRules

FACTS = Path(__file__).parent / "facts"
TIA_FACTS: dict[str, Any] = json.loads((FACTS / "tia.json").read_text())
MACHINE_FACTS: dict[str, Any] = json.loads((FACTS / "machine.json").read_text())

W = SimpleNamespace(**{name: address for name, (address, _) in TIA_FACTS["write_registers"].items()})
"""Addresses of the TIA's registers for writing: `W.COLUBK`."""

R = SimpleNamespace(
    CXM0P=0, CXM1P=1, CXP0FB=2, CXP1FB=3, CXM0FB=4, CXM1FB=5, CXBLPF=6, CXPPMM=7,
    INPT0=8, INPT1=9, INPT2=10, INPT3=11, INPT4=12, INPT5=13,
    SWCHA=0x280, SWACNT=0x281, SWCHB=0x282, SWBCNT=0x283, INTIM=0x284, TIMINT=0x285,
    TIM1T=0x294, TIM8T=0x295, TIM64T=0x296, T1024T=0x297,
)  # fmt: skip
"""Addresses of the TIA's registers for reading, and of the RIOT's."""

NOP = 0xEA
JAM = 0x02


def rom(program: bytes | list[int] = b"", *, banks: int = 1, start: int = 0xF000, vector: int | None = None) -> bytes:
    """An image of 4 KiB banks, each with the program at `start` and the vectors pointing to it; NOPs elsewhere."""
    bank = bytearray([NOP]) * 4096
    offset = start & 0xFFF
    bank[offset : offset + len(program)] = bytes(program)
    word = (start if vector is None else vector).to_bytes(2, "little")
    bank[-4:] = word + word
    return bytes(bank) * banks


def console(program: bytes | list[int] = b"", **options: Any) -> Console:
    """A 4 KiB cartridge with this program at $F000, reset."""
    return Console(rom(program), "4K", **options)


def game_of(image: bytes, rules: CompiledRules, cartridge: str = "", rows: int = 210) -> _emulator.Game:
    """An image under some rules, for the extension module; 250 rows are PAL."""
    return _emulator.make_game(
        image=image, cartridge=cartridge, format="PAL" if rows == 250 else "NTSC", detect_format=True, first_line=34,
        height=rows, hmove_blanks=True, paddles=(False, False), swap_ports=False, swap_paddles=False,
        paddle_range=(27450, 790196), power_on_switches=0x3F, legal_actions=list(range(18)), starting_actions=[],
        default_mode=0, variables=rules.variables, initial=rules.initial, kept=rules.kept, outputs=rules.outputs,
        step=rules.step, select_mode=rules.select_mode,
    )  # fmt: skip


def emulator(game: _emulator.Game, *, plain: bool = False) -> _emulator.Emulator:
    """The native or the plain emulator of a game, with sound and without sticky actions."""
    return _emulator.Emulator(
        game=game, repeat_action_probability=0.0, frame_skip=1, max_num_frames_per_episode=0, sound=True,
        color_averaging=False, seed=1, plain=plain,
    )  # fmt: skip


def beam(height: int = 8, **options: Any) -> Console:
    """A console in its first frame. Row 0 is line 0. Tests write registers at chosen times."""
    machine = console(first_line=0, height=height, **options)
    machine.start_frame()
    return machine


def write_at(machine: Console, line: int, cycle: int, register: int, value: int = 0) -> None:
    """A write at a cycle of a line (the lines of a `beam` begin at multiples of 76 cycles)."""
    machine.cycles = 76 * line + cycle
    machine.write(register, value)


def framebuffer(machine: Console) -> Any:
    """The framebuffer, rendered up to the current cycle by a read of a register that drives no bit."""
    machine.read(0x0E)
    return machine.framebuffer()


def run(machine: Console, instructions: int) -> None:
    """Run some instructions."""
    for _ in range(instructions):
        machine.step()
