"""Random accesses of the TIA at random times, against the model that draws pixel by pixel."""

import random

import numpy as np
import pytest
from emulator.machines import W, beam, framebuffer
from emulator.model_tia import COLLISION_REGISTERS, ModelTia

HEIGHT = 16
SHOWN = [register for register in range(0x2D) if register not in (W.VSYNC, W.WSYNC)]
GROUPS = [
    [W.GRP0, W.GRP1, W.VDELP0, W.VDELP1, W.VDELBL, W.ENABL],
    [W.NUSIZ0, W.NUSIZ1, W.RESMP0, W.RESMP1, W.ENAM0, W.ENAM1],
    [W.CTRLPF, W.PF0, W.PF1, W.PF2, W.COLUPF, W.COLUP0],
    [W.HMP0, W.HMP1, W.HMM0, W.HMM1, W.HMBL, W.HMOVE],
]
STROBES = [W.RESP0, W.RESP1, W.RESM0, W.RESM1, W.RESBL, W.HMOVE]
SOON_AFTER_HMOVE = [(21, W.HMM0), (3, W.RESM1), (20, W.RESM0), *((k, W.RESBL) for k in (3, 6, 7, 18))]


def accesses(rng: random.Random) -> list[tuple[int, int, int]]:
    """(cycle, register, value), at least three cycles apart, as instructions are."""
    program, cycle = [], 0
    favourites = rng.choice([*GROUPS, rng.sample(SHOWN, 6)])
    while cycle < 76 * HEIGHT:
        choice = rng.random()
        register = rng.choice(SHOWN if choice < 0.5 else favourites if choice < 0.8 else STROBES)
        value = rng.choice((0x00, 0xFF, 1 << rng.randrange(8), rng.randrange(256)))
        if register == W.VBLANK and rng.random() < 0.8:
            value &= ~2
        program.append((cycle, register, value))
        if register == W.HMOVE and rng.random() < 0.5:  # a later write of HMM0 has a special effect
            program[-1:] = [(cycle, W.HMM0, 0x70), (cycle + 3, W.HMOVE, 0)]
            after, later = rng.choice(SOON_AFTER_HMOVE)
            cycle += 3 + after
            program.append((cycle, later, 0x60))
        cycle += rng.choice((3, 3, 4, 5, 6, 8, 20, 76 - cycle % 76 if cycle % 76 <= 73 else 3))
    return program


@pytest.mark.parametrize("batch", range(20))
def test_as_model(batch: int) -> None:
    for seed in range(15 * batch, 15 * batch + 15):
        compare(random.Random(seed))


def compare(rng: random.Random) -> None:
    """One frame: positions after every write, collisions at random times, the framebuffer at the end."""
    machine, model = beam(HEIGHT), ModelTia(HEIGHT)
    for cycle, register, value in accesses(rng):
        machine.cycles = cycle
        machine.write(register, value)
        model.write(cycle, register, value)
        if rng.random() < 0.1:
            flags = rng.choice(COLLISION_REGISTERS)
            assert machine.read(flags) & 0xC0 == model.read_collisions(cycle, flags), (cycle, flags)
        if model.cosmic_ark:
            framebuffer(machine)  # the emulator moves the star when it renders the end of the line
        assert machine.positions == model.pos, (cycle, register)
    machine.cycles = 76 * (HEIGHT + 1)
    model.draw_to(3 * machine.cycles)
    np.testing.assert_array_equal(framebuffer(machine), model.framebuffer)
    assert [machine.read(flags) & 0xC0 for flags in COLLISION_REGISTERS] == [
        model.read_collisions(machine.cycles, flags) for flags in COLLISION_REGISTERS
    ]
