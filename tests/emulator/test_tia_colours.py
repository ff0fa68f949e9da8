"""Which colour a pixel takes, which collisions it latches, and what blanks it."""

import itertools

import numpy as np
import pytest
from atari_inspection import Console
from emulator.machines import TIA_FACTS, R, W, beam, console, framebuffer, write_at

COLOURS = {"P0": 0x12, "P1": 0x24, "PF": 0x36, "BK": 0x48}
OBJECTS = ("P0", "P1", "M0", "M1", "BL", "PF")
PAIRS = {frozenset((a, b)): (register, bit) for register, bit, a, b in TIA_FACTS["collisions"]}


def show(machine: Console, objects: tuple[str, ...], column: int = 40, other: int = 120) -> None:
    """Put some objects at a column, and the others, also enabled, elsewhere; the playfield is all on or off."""
    machine.positions = [
        (column if name in objects else other) - (1 if name in ("P0", "P1") else 0) for name in OBJECTS[:5]
    ]
    for number, name in enumerate(("P0", "P1")):
        machine.write(W.GRP0 + number, 0x40 if name in objects else 0x00)
        machine.write(W.ENAM0 + number, 0x02 if f"M{number}" in objects else 0x00)
    machine.write(W.ENABL, 0x02 if "BL" in objects else 0x00)
    for register in (W.PF0, W.PF1, W.PF2):
        machine.write(register, 0xFF if "PF" in objects else 0x00)


def coloured(ctrlpf: int) -> Console:
    machine = beam()
    for k, colour in enumerate(COLOURS.values()):
        machine.write(W.COLUP0 + k, colour)
    machine.write(W.CTRLPF, ctrlpf)
    return machine


def expected_colour(lit: tuple[str, ...], score: bool, playfield_first: bool, column: int) -> str:
    """The two tables of priority, written as lists."""
    side = "P0" if column < 80 else "P1"
    if playfield_first:
        alone = lit == ("PF",)
        order = [
            ("PF", side if score and alone else "PF"),
            ("BL", "PF"),
            ("P0", "P0"),
            ("M0", "P0"),
            ("P1", "P1"),
            ("M1", "P1"),
        ]
    else:
        order = [("P0", "P0"), ("M0", "P0")]
        order += [("PF", side)] if score else []
        order += [("P1", "P1"), ("M1", "P1"), ("PF", "PF"), ("BL", "PF")]
    return next((colour for name, colour in order if name in lit), "BK")


@pytest.mark.parametrize("column", [40, 79, 80, 101])
@pytest.mark.parametrize("ctrlpf", [0, 2, 4, 6], ids=["plain", "score", "priority", "score and priority"])
def test_priorities(ctrlpf: int, column: int) -> None:
    """All 64 sets of objects at one pixel."""
    for size in range(7):
        for lit in itertools.combinations(OBJECTS, size):
            machine = coloured(ctrlpf)
            show(machine, lit, column)
            machine.cycles = 76
            colour = COLOURS[expected_colour(lit, ctrlpf & 2 > 0, ctrlpf & 4 > 0, column)]
            assert framebuffer(machine)[0, column] == colour, lit


def test_score_colours_change_in_the_middle() -> None:
    machine = coloured(2)
    show(machine, ("PF",))
    machine.cycles = 76
    assert framebuffer(machine)[0].tolist() == [COLOURS["P0"]] * 80 + [COLOURS["P1"]] * 80


def test_score_with_priority_ends_when_anything_else_is_enabled() -> None:
    """Any other enabled object, lit or not, ends the score mode with priority in the whole step."""
    machine = coloured(6)
    show(machine, ("PF",))
    write_at(machine, 1, 0, W.ENABL, 2)
    machine.cycles = 2 * 76
    assert framebuffer(machine)[0].tolist() == [COLOURS["P0"]] * 80 + [COLOURS["P1"]] * 80
    assert framebuffer(machine)[1].tolist() == [COLOURS["PF"]] * 160


@pytest.mark.parametrize("register", range(4))
def test_colours_are_even(register: int) -> None:
    machine = beam()
    for value in (0xFF, 0x01, 0x42):
        machine.write(W.COLUP0 + register, value)
        assert machine.state()["tia"]["colour"][register] == value & 0xFE


# -- collisions


def collided(machine: Console) -> set[frozenset[str]]:
    """The pairs of objects whose latches are set; all other bits of the registers come from the bus."""
    pairs = set()
    for pair, (register, bit) in PAIRS.items():
        machine.write(0x80, 0)
        if machine.read(register) >> bit & 1:
            pairs.add(pair)
    return pairs


def test_pairs_are_fifteen() -> None:
    assert set(PAIRS) == {frozenset(pair) for pair in itertools.combinations(OBJECTS, 2)}


def test_collisions_of_all_sets() -> None:
    """All pairs of objects at one pixel collide, and no others."""
    for size in range(7):
        for lit in itertools.combinations(OBJECTS, size):
            machine = coloured(0)
            show(machine, lit)
            machine.cycles = 76
            assert collided(machine) == {frozenset(pair) for pair in itertools.combinations(lit, 2)}, lit


@pytest.mark.parametrize("pair", list(itertools.combinations(OBJECTS[:5], 2)), ids="-".join)
def test_neighbours_do_not_collide(pair: tuple[str, str]) -> None:
    machine = coloured(0)
    show(machine, pair)
    places = list(machine.positions)
    places[OBJECTS.index(pair[1])] += 1
    machine.positions = places
    machine.cycles = 76
    assert collided(machine) == set()


def test_latches_stay_until_cleared() -> None:
    machine = coloured(0)
    show(machine, ("P0", "M1"))
    machine.cycles = 76
    show(machine, ())
    machine.cycles = 5 * 76
    assert collided(machine) == {frozenset(("P0", "M1"))}
    machine.write(W.CXCLR, 0)
    assert collided(machine) == set()


def test_clearing_drops_what_the_beam_has_passed_alone() -> None:
    """Columns 40 and 100 collide; after a clear between them, the second collision is latched again."""
    machine = coloured(0)
    machine.write(W.NUSIZ0, 4)
    show(machine, ("P0", "PF"), column=30)  # copies at 30 and 94
    write_at(machine, 0, 45, W.CXCLR, 0)  # column 67
    assert collided(machine) == set()
    machine.cycles = 60  # column 112
    assert collided(machine) == {frozenset(("P0", "PF"))}


def test_collisions_come_with_the_beam() -> None:
    machine = coloured(0)
    show(machine, ("P0", "BL"))
    for cycle in (0, 22, 35, 36):
        machine.cycles = cycle
        assert collided(machine) == set()
    machine.cycles = 37  # column 43
    assert collided(machine) == {frozenset(("P0", "BL"))}


def test_no_collisions_outside_the_framebuffer_or_while_blank() -> None:
    machine = beam(height=4)
    machine.write(W.VBLANK, 0x02)
    show(machine, OBJECTS)
    machine.cycles = 2 * 76
    assert collided(machine) == set()
    assert not framebuffer(machine)[:2].any()
    machine.write(W.GRP0, 0)
    machine.write(W.PF0, 0)
    show(machine, ())
    machine.write(W.VBLANK, 0x00)
    machine.cycles = 4 * 76
    show(machine, OBJECTS)
    machine.cycles = 20 * 76  # lines below the framebuffer
    assert collided(machine) == set()


def test_bits_of_vblank() -> None:
    """Bit 1 blanks; bits 6 and 7 do not."""
    machine = coloured(0)
    for line, value in enumerate((0xC0, 0x02, 0xFD, 0xFF)):
        write_at(machine, line, 0, W.VBLANK, value)
    machine.cycles = 4 * 76
    assert framebuffer(machine)[:4, 50].tolist() == [COLOURS["BK"], 0, COLOURS["BK"], 0]


def test_registers_show_the_bus_in_their_low_bits() -> None:
    machine = coloured(0)
    show(machine, OBJECTS)
    machine.cycles = 76
    for register in range(16):
        for mirror in (0x0000, 0x0010, 0x0100, 0x2040):
            machine.write(0x80, 0xFF)
            expected = {R.CXBLPF: 0x80, R.INPT4: 0x80, R.INPT5: 0x80}.get(register, 0xC0 if register < 8 else 0x00)
            assert machine.read(register + mirror) == expected | 0x3F, (register, mirror)


# -- HMOVE's blank


@pytest.mark.parametrize("cycle", range(76))
def test_hmove_blanks_eight_columns(cycle: int) -> None:
    """HMOVE blanks columns of its line, or of the next one if it comes in the last cycle of a line."""
    machine = coloured(0)
    write_at(machine, 2, cycle, W.HMOVE)
    machine.cycles = 6 * 76
    black = [[line, column] for line, column in np.argwhere(framebuffer(machine)[:6] == 0)]
    blanked = {75: 3}.get(cycle, 2 if cycle <= 20 else None)
    assert black == ([] if blanked is None else [[blanked, column] for column in range(8)])


def test_hmove_blank_can_be_switched_off() -> None:
    machine = beam(hmove_blanks=False)
    machine.write(W.COLUBK, 0x0E)
    write_at(machine, 2, 3, W.HMOVE)
    machine.cycles = 4 * 76
    assert framebuffer(machine)[:4].all()


def test_blanked_columns_still_collide() -> None:
    machine = coloured(0)
    show(machine, ("M0", "BL"), column=3)
    write_at(machine, 0, 3, W.HMOVE)
    machine.cycles = 76
    assert framebuffer(machine)[0, 3] == 0
    assert collided(machine) == {frozenset(("M0", "BL"))}


def test_hmove_above_the_framebuffer_blanks_its_first_line() -> None:
    machine = console(first_line=10, height=4)
    machine.start_frame()
    machine.write(W.COLUBK, 0x0E)
    write_at(machine, 4, 3, W.HMOVE)
    machine.cycles = 20 * 76
    assert [line[:9].tolist() for line in framebuffer(machine)] == [[0] * 8 + [0x0E]] + [[0x0E] * 9] * 3
