"""The shapes of objects: each alone in a line, at every column, against a function for a single pixel."""

import random

import numpy as np
import pytest
from atari_inspection import Console
from emulator.machines import TIA_FACTS, W, beam, framebuffer, write_at
from emulator.model_tia import ball_lit, missile_lit, player_lit, playfield_lit, reversed_bits, row


def lines_of(machine: Console, positions: range, item: int) -> np.ndarray:
    """The lit pixels of one line for each position of an object."""
    for line, position in enumerate(positions):
        machine.cycles = 76 * line
        framebuffer(machine)
        places = [0] * 5
        places[item] = position
        machine.positions = places
    machine.cycles = 76 * len(positions)
    lit: np.ndarray = framebuffer(machine)[: len(positions)] != 0
    return lit


@pytest.mark.parametrize("mode", range(8))
@pytest.mark.parametrize("number", [0, 1])
def test_players(number: int, mode: int) -> None:
    """Players at every column: single, in copies, double and quadruple."""
    for graphics in (0x80, 0x01, 0xFF, 0xB2):
        machine = beam(height=160)
        machine.write(W.NUSIZ0 + number, mode | 0xF8)  # the other bits are the missile's, or have no effect
        machine.write(W.COLUP0 + number, 0x1E)
        machine.write(W.GRP0 + number, graphics)
        lit = lines_of(machine, range(160), number)
        for position in range(160):
            expected = row(player_lit(x, position, mode, graphics, False) for x in range(160))
            np.testing.assert_array_equal(lit[position], expected, err_msg=f"{graphics:02x} at {position}")


@pytest.mark.parametrize("mode", [0, 3, 5, 7])
def test_all_graphics(mode: int) -> None:
    """All 256 patterns, straight and reflected."""
    for reflected in (0, 8):
        for start in (0, 128):
            machine = beam(height=128)
            machine.write(W.NUSIZ1, mode)
            machine.write(W.COLUP1, 0x0E)
            machine.write(W.REFP1, reflected | 0x07)
            machine.positions = [0, 101, 0, 0, 0]
            for line in range(128):
                write_at(machine, line, 0, W.GRP1, start + line)
            machine.cycles = 76 * 128
            lit = framebuffer(machine) != 0
            for line in range(128):
                shown = reversed_bits(start + line) if reflected else start + line
                expected = row(player_lit(x, 101, mode, shown, False) for x in range(160))
                np.testing.assert_array_equal(lit[line], expected, err_msg=f"{shown:02x}")


@pytest.mark.parametrize("mode", range(8))
@pytest.mark.parametrize("number", [0, 1])
def test_missiles(number: int, mode: int) -> None:
    for size in range(4):
        machine = beam(height=160)
        machine.write(W.NUSIZ0 + number, mode | size << 4)
        machine.write(W.COLUP0 + number, 0x0E)
        machine.write(W.ENAM0 + number, 0x02)
        lit = lines_of(machine, range(160), 2 + number)
        for position in range(160):
            expected = row(missile_lit(x, position, mode, size) for x in range(160))
            np.testing.assert_array_equal(lit[position], expected, err_msg=f"size {size} at {position}")


@pytest.mark.parametrize("size", range(4))
def test_ball(size: int) -> None:
    machine = beam(height=160)
    machine.write(W.CTRLPF, size << 4)
    machine.write(W.COLUPF, 0x0E)
    machine.write(W.ENABL, 0x02)
    lit = lines_of(machine, range(160), 4)
    for position in range(160):
        np.testing.assert_array_equal(lit[position], row(ball_lit(x, position, size) for x in range(160)))
    assert lit.sum(axis=1).tolist() == [1 << size] * 160


def test_enables_are_bit_1() -> None:
    for register, item in ((W.ENAM0, 2), (W.ENAM1, 3), (W.ENABL, 4)):
        machine = beam()
        for colour in range(W.COLUP0, W.COLUBK):
            machine.write(colour, 0x0E)
        machine.positions = [0, 0, 20, 30, 40]
        for line, value in enumerate((0x02, 0xFD, 0xFF, 0x00)):
            write_at(machine, line, 0, register, value)
        machine.cycles = 4 * 76
        assert framebuffer(machine)[:4, 10 * item].tolist() == [0x0E, 0, 0x0E, 0]


@pytest.mark.parametrize("mirror", [False, True], ids=["repeat", "mirror"])
def test_playfield(mirror: bool) -> None:
    """Every bit of the 20 alone, then random patterns: PF0 low bit first, PF1 high bit first, PF2 low bit first."""
    rng = random.Random(1)
    patterns = [1 << bit for bit in range(20)] + [rng.randrange(1 << 20) for _ in range(200)]
    machine = beam(height=len(patterns))
    machine.write(W.COLUPF, 0x0E)
    machine.write(W.CTRLPF, 0x01 if mirror else 0x00)
    for line, playfield in enumerate(patterns):
        write_at(machine, line, 0, W.PF0, (playfield & 0xF) << 4 | rng.randrange(16))  # the low nibble has no effect
        machine.write(W.PF1, playfield >> 4 & 0xFF)
        machine.write(W.PF2, playfield >> 12)
    machine.cycles = 76 * len(patterns)
    lit = framebuffer(machine) != 0
    for line, playfield in enumerate(patterns):
        expected = row(playfield_lit(x, playfield, mirror) for x in range(160))
        np.testing.assert_array_equal(lit[line], expected, err_msg=f"{playfield:05x}")


def test_playfield_by_hand() -> None:
    machine = beam()
    machine.write(W.COLUPF, 0x0E)
    machine.write(W.PF0, 0x10)  # the leftmost cell
    machine.write(W.PF1, 0x80)  # the fifth
    machine.write(W.PF2, 0x80)  # the twentieth
    write_at(machine, 1, 0, W.CTRLPF, 0x01)
    machine.cycles = 2 * 76
    cells = [np.flatnonzero(line.reshape(40, 4).all(axis=1)).tolist() for line in framebuffer(machine)[:2] != 0]
    assert cells == [[0, 4, 19, 20, 24, 39], [0, 4, 19, 20, 35, 39]]


# -- the reflect bit is latched: at once until shortly before column 79, later at the end of the line


@pytest.mark.parametrize("cycle", range(76))
def test_reflect_latch(cycle: int) -> None:
    machine = beam()
    machine.write(W.COLUPF, 0x0E)
    machine.write(W.PF0, 0x10)  # cell 0, and 20 or 39
    write_at(machine, 1, cycle, W.CTRLPF, 0x01)
    machine.cycles = 76 * 3
    lit = framebuffer(machine) != 0
    in_time = 3 * cycle < 147
    assert lit[1, 156:].all() == in_time
    assert lit[1, 80:84].all() != in_time
    assert lit[2, 156:].all()
    assert not lit[2, 80:84].any()


def test_late_reflect_is_undone_early_in_the_next_line() -> None:
    """The end of a line is between the two writes, although no pixel is rendered between them."""
    machine = beam()
    machine.write(W.COLUPF, 0x0E)
    machine.write(W.PF0, 0x10)
    write_at(machine, 1, 70, W.CTRLPF, 0x01)
    write_at(machine, 2, 10, W.CTRLPF, 0x00)
    machine.cycles = 76 * 3
    assert framebuffer(machine)[2, 80:84].all()
    assert not framebuffer(machine)[2, 156:].any()


# -- vertical delay


def shown_at(machine: Console, column: int) -> bool:
    """Whether a column is lit in the rest of the line; the time becomes that of the next line."""
    line = machine.cycles // 76 + 1
    machine.cycles = 76 * line
    return bool(framebuffer(machine)[line - 1, column])


def test_delayed_players_show_what_was_there_before_the_other_was_written() -> None:
    for player in (0, 1):
        other = player ^ 1
        machine = beam(height=20)
        machine.positions = [20, 20, 0, 0, 0]
        machine.write(W.COLUP0 + player, 0x0E)
        machine.write(W.VDELP0 + player, 0xFE)  # bit 0 alone counts
        machine.write(W.GRP0 + player, 0x80)
        assert shown_at(machine, 20)
        machine.write(W.VDELP0 + player, 0x01)
        assert not shown_at(machine, 20)  # the old copy is still 0
        machine.write(W.GRP0 + other, 0x00)
        assert shown_at(machine, 20)
        machine.write(W.GRP0 + player, 0x00)
        assert shown_at(machine, 20)  # still the old copy
        machine.write(W.VDELP0 + player, 0x00)
        assert not shown_at(machine, 20)
        tia = machine.state()["tia"]
        assert (tia["grp"][player], tia["old_grp"][player]) == (0x00, 0x80)


def test_delayed_ball_waits_for_player_1() -> None:
    machine = beam(height=20)
    machine.positions = [0, 0, 0, 0, 70]
    machine.write(W.COLUPF, 0x0E)
    machine.write(W.VDELBL, 0x01)
    machine.write(W.ENABL, 0x02)
    assert not shown_at(machine, 70)
    machine.write(W.GRP0, 0x00)
    assert not shown_at(machine, 70)
    machine.write(W.GRP1, 0x00)
    assert shown_at(machine, 70)
    machine.write(W.ENABL, 0x00)
    assert shown_at(machine, 70)
    machine.write(W.VDELBL, 0x00)
    assert not shown_at(machine, 70)


# -- when the effect of a write begins


def first_change(machine: Console, line: int, cycle: int, register: int, value: int) -> int:
    """The first column in which a write makes a line differ from the line before."""
    write_at(machine, line, cycle, register, value)
    machine.cycles = 76 * (line + 1)
    shown = framebuffer(machine)
    return int(np.flatnonzero(shown[line] != shown[line - 1])[0])


@pytest.mark.parametrize("cycle", range(26, 65))
def test_when_writes_show(cycle: int) -> None:
    """The effect of a write begins some clocks after the end of the instruction, by register."""
    column = 3 * cycle - 68
    delays = {name: delay for name, (_, delay) in TIA_FACTS["write_registers"].items()}
    pf_delay = TIA_FACTS["playfield_delay_by_cycle_mod_4"][cycle % 4]

    def prepared(*writes: tuple[int, int]) -> Console:
        machine = beam()
        for k, colour in enumerate((0x12, 0x24, 0x36, 0x48)):
            machine.write(W.COLUP0 + k, colour)
        for register, value in writes:
            machine.write(register, value)
        return machine

    assert first_change(prepared(), 1, cycle, W.COLUBK, 0x0E) == column + delays["COLUBK"]
    assert first_change(prepared(), 1, cycle, W.VBLANK, 0x02) == column + delays["VBLANK"]
    whole = [(register, 0xFF) for register in (W.PF0, W.PF1, W.PF2)]
    assert first_change(prepared(*whole), 1, cycle, W.COLUPF, 0x0E) == column + delays["COLUPF"]
    assert first_change(prepared(*whole), 1, cycle, W.CTRLPF, 0x02) == column + delays["CTRLPF"]
    for number, name in ((0, "0"), (1, "1")):
        wide = prepared((W.NUSIZ0 + number, 7))
        wide.positions = [(column - 8) % 160] * 5
        assert first_change(wide, 1, cycle, W.GRP0 + number, 0xFF) == column + delays[f"GRP{name}"]
        wide = prepared((W.NUSIZ0 + number, 7), (W.GRP0 + number, 0xF0))  # sixteen columns lit, sixteen not
        wide.positions = [(column - 8) % 160] * 5
        assert first_change(wide, 1, cycle, W.REFP0 + number, 8) == column + delays[f"REFP{name}"]
        wide = prepared((W.NUSIZ0 + number, 7), (W.GRP0 + number, 0xFF))
        wide.positions = [(column - 16) % 160] * 5
        assert first_change(wide, 1, cycle, W.NUSIZ0 + number, 0) == column + delays[f"NUSIZ{name}"]
        missile = prepared((W.NUSIZ0 + number, 0x30))
        missile.positions = [(column - 2) % 160] * 5
        assert first_change(missile, 1, cycle, W.ENAM0 + number, 2) == column + delays[f"ENAM{name}"]
        missile = prepared((W.NUSIZ0 + number, 0x30), (W.ENAM0 + number, 2))
        missile.positions = [(column + 2) % 160] * 5  # eight columns; strobed, it goes two columns on
        assert first_change(missile, 1, cycle, W.RESM0 + number, 0) == column + 10
        assert delays[f"RESM{name}"] == 8
        # A write of one player's graphics also changes the delayed graphics of the other player.
        delayed = prepared((W.NUSIZ0, 7), (W.NUSIZ1, 7), (W.VDELP0, 1), (W.VDELP1, 1), (W.GRP0 + (1 - number), 0xFF))
        delayed.positions = [(column - 8) % 160] * 5
        assert first_change(delayed, 1, cycle, W.GRP0 + number, 0) == column + delays[f"GRP{name}"]
    ball = prepared((W.CTRLPF, 0x30), (W.VDELBL, 1), (W.ENABL, 2))
    ball.positions = [(column - 2) % 160] * 5
    assert first_change(ball, 1, cycle, W.GRP1, 0) == column + delays["GRP1"]
    ball = prepared((W.CTRLPF, 0x30))
    ball.positions = [(column - 2) % 160] * 5
    assert first_change(ball, 1, cycle, W.ENABL, 2) == column + delays["ENABL"]
    for register, cells in ((W.PF0, range(4)), (W.PF1, range(4, 12)), (W.PF2, range(12, 20))):
        columns = [x for x in range(160) if x // 4 % 20 in cells and x >= column + pf_delay]
        if columns:  # PF0 has cells at the left edge and in the middle alone
            assert first_change(prepared(), 1, cycle, register, 0xFF) == columns[0]
