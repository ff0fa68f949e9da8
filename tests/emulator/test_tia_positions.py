"""The positions of objects: strobes, HMOVE, missiles locked to players, and the stars of Cosmic Ark."""

import numpy as np
import pytest
from atari_inspection import Console
from emulator.machines import TIA_FACTS, W, beam, framebuffer, write_at

P0, P1, M0, M1, BL = range(5)
STROBES = {P0: W.RESP0, P1: W.RESP1, M0: W.RESM0, M1: W.RESM1, BL: W.RESBL}
DELTAS = TIA_FACTS["hmove_delta_by_cycle_and_nibble"]


@pytest.mark.parametrize("item", STROBES)
def test_strobe_at_each_cycle(item: int) -> None:
    """A strobe puts players 5 columns after the beam and other objects 4; during the blank at columns 3 and 2."""
    delay, blank = (5, 3) if item in (P0, P1) else (4, 2)
    for cycle in range(76):
        machine = beam()
        write_at(machine, 3, cycle, STROBES[item])
        column = 3 * cycle - 68
        expected = [0] * 5
        expected[item] = blank if column < 0 else (column + delay) % 160
        assert machine.positions == expected, cycle


@pytest.mark.parametrize("case", TIA_FACTS["strobes_after_hmove"], ids=lambda c: f"{c['register']} {c['position']}")
def test_strobe_soon_after_hmove(case: dict[str, object]) -> None:
    """At some distances from HMOVE, in the same line, a strobe puts a missile or the ball at another column."""
    register = getattr(W, str(case["register"]))
    item = register - W.RESP0
    for hpos in case["hpos"]:  # type: ignore[attr-defined]
        for since in range(3, 100, 3):
            machine = beam()
            machine.cycles = 5 * 76 + hpos // 3 - since // 3
            machine.write(W.HMOVE, 0)
            machine.cycles = 5 * 76 + hpos // 3
            machine.write(register, 0)
            usual = 2 if hpos < 68 else hpos - 68 + 4
            special = [
                c["position"]
                for c in TIA_FACTS["strobes_after_hmove"]
                if c["register"] == case["register"] and c["clocks_since_hmove"] == since and hpos in c["hpos"]
            ]
            assert machine.positions[item] == (special or [usual])[0], (hpos, since)


def move_all(cycle: int, nibbles: list[int], start: int = 80) -> list[int]:
    machine = beam()
    for k, nibble in enumerate(nibbles):
        machine.write(W.HMP0 + k, nibble << 4)
    machine.positions = [start] * 5
    write_at(machine, 2, cycle, W.HMOVE)
    return list(machine.positions)


@pytest.mark.parametrize("cycle", range(76))
def test_hmove_at_each_cycle(cycle: int) -> None:
    """All motions of all objects equal the table; the low nibble of a motion register has no effect."""
    for nibble in range(16):
        nibbles = [(nibble + k) % 16 for k in range(5)]
        assert move_all(cycle, nibbles) == [80 + DELTAS[cycle][n] for n in nibbles]
    machine = beam()
    machine.write(W.HMBL, 0x1F)
    machine.positions = [80] * 5
    write_at(machine, 2, cycle, W.HMOVE)
    assert machine.positions[BL] == 80 + DELTAS[cycle][1]


def test_hmove_in_the_usual_place() -> None:
    """Right after WSYNC: -8 to the right ... 7 to the left."""
    assert [move_all(3, [n] * 5)[P0] - 80 for n in range(16)] == [0, -1, -2, -3, -4, -5, -6, -7, 8, 7, 6, 5, 4, 3, 2, 1]


def test_hmove_goes_round() -> None:
    assert move_all(0, [7, 8, 1, 15, 0], start=0) == [153, 8, 159, 1, 0]
    assert move_all(0, [7, 8, 1, 15, 0], start=159) == [152, 7, 158, 0, 159]


def test_hmclr() -> None:
    machine = beam()
    for k in range(5):
        machine.write(W.HMP0 + k, 0x70)
    assert machine.state()["tia"]["hm"] == [7] * 5
    machine.write(W.HMCLR, 0xFF)
    assert machine.state()["tia"]["hm"] == [0] * 5


@pytest.mark.parametrize("mode", range(8))
@pytest.mark.parametrize("number", [0, 1])
def test_missile_locked_to_its_player(mode: int, number: int) -> None:
    """A missile is hidden while RESMP is set; clearing RESMP puts it at the middle of its player."""
    machine = beam()
    machine.positions = [100, 150, 10, 20, 30]
    machine.write(W.NUSIZ0 + number, mode | 0x30)
    machine.write(W.COLUP0 + number, 0x0E)
    machine.write(W.ENAM0 + number, 2)
    machine.write(W.RESMP0 + number, 2)
    assert machine.positions[M0 + number] == (10, 20)[number]  # it does not follow its player
    machine.cycles = 76
    assert not framebuffer(machine).any()
    machine.write(W.RESMP0 + number, 0xFD)  # bit 1 alone counts
    middle = {5: 8, 7: 16}.get(mode, 4)
    position = ((100, 150)[number] + middle) % 160
    assert machine.positions[M0 + number] == position
    machine.cycles = 2 * 76
    assert framebuffer(machine)[1, position] == 0x0E
    machine.write(W.RESMP0 + number, 0)  # was 0 already: nothing
    machine.positions = [0, 0, 50, 60, 0]
    machine.write(W.RESMP0 + number, 0)
    assert machine.positions[M0 + number] == (50, 60)[number]


def test_hidden_missile_can_be_strobed() -> None:
    machine = beam()
    machine.write(W.RESMP0, 2)
    write_at(machine, 0, 40, W.RESM0)
    assert machine.positions[M0] == 3 * 40 - 68 + 4


# -- a strobed player leaves out its first copy


def lit_columns(machine: Console, line: int) -> list[int]:
    return [int(x) for x in np.flatnonzero(framebuffer(machine)[line])]


def strobed(old: int, cycle: int, nusiz: int) -> Console:
    """Player 0 at a column, strobed in line 1; its graphics are one pixel at its left end."""
    machine = beam()
    machine.positions = [old, 0, 0, 0, 0]
    machine.write(W.NUSIZ0, nusiz)
    machine.write(W.COLUP0, 0x0E)
    machine.write(W.GRP0, 0x80)
    write_at(machine, 1, cycle, W.RESP0)
    machine.cycles = 76 * 5
    return machine


def test_first_copy_is_hidden_until_the_end_of_the_line() -> None:
    machine = strobed(old=0, cycle=40, nusiz=1)  # to column 57, a second copy at 73
    assert lit_columns(machine, 0) == [0, 16]
    assert lit_columns(machine, 1) == [0, 16, 73]
    assert lit_columns(machine, 2) == [57, 73]


def test_first_copy_is_shown_where_the_old_one_was_about_to_start() -> None:
    """The column of the strobe is up to three columns after the beginning of an old copy."""
    for distance in range(-2, 9):
        machine = strobed(old=57 - distance, cycle=40, nusiz=0)
        hidden = not 0 <= distance < 4
        # Pixels before the beam (column 52, or 11 clocks more while the player is shown) are those of the old position.
        old = [57 - distance] if 57 - distance < 52 + (11 if 4 <= distance < 12 else 0) else []
        assert lit_columns(machine, 1) == sorted(set(old + ([] if hidden else [57]))), distance
        assert lit_columns(machine, 2) == [57]


def test_player_being_shown_goes_on_for_eleven_clocks() -> None:
    machine = beam()
    machine.positions = [50, 0, 0, 0, 0]
    machine.write(W.NUSIZ0, 7)
    machine.write(W.COLUP0, 0x0E)
    machine.write(W.GRP0, 0xFF)
    write_at(machine, 1, 40, W.RESP0)  # at column 52
    machine.cycles = 76 * 3
    assert lit_columns(machine, 0) == list(range(51, 83))
    assert lit_columns(machine, 1) == list(range(51, 52 + 11))
    assert lit_columns(machine, 2) == list(range(58, 90))


@pytest.mark.parametrize("register", [W.NUSIZ0, W.HMOVE], ids=["NUSIZ0", "HMOVE"])
def test_what_shows_the_first_copy_again(register: int) -> None:
    machine = strobed(old=80, cycle=20, nusiz=0)  # in the blank, to column 3
    assert lit_columns(machine, 1) == []
    machine = beam(hmove_blanks=False)
    machine.write(W.COLUP0, 0x0E)
    machine.write(W.GRP0, 0x80)
    machine.positions = [80, 0, 0, 0, 0]
    write_at(machine, 1, 10, W.RESP0)
    write_at(machine, 1, 14, register)
    delta = DELTAS[14][0] if register == W.HMOVE else 0
    machine.cycles = 76 * 2
    assert lit_columns(machine, 1) == [3 + delta]


# -- Cosmic Ark


def stars(lines: int, end_with: int | None = None) -> tuple[Console, list[list[int]]]:
    """The lit columns of some lines, with missile 0 of width 1 at column 100, which HMOVE in line 0 sets in motion."""
    machine = beam(height=10)
    machine.write(W.HMM0, 0x70)
    machine.write(W.COLUP0, 0x0E)
    write_at(machine, 0, 3, W.HMOVE)
    write_at(machine, 0, 24, W.HMM0, 0x60)  # 63 clocks later
    machine.write(W.ENAM0, 2)
    machine.positions = [0, 0, 100, 0, 0]
    if end_with is not None:
        write_at(machine, 4, 0, end_with)
    machine.cycles = max(machine.cycles, 76 * lines)
    return machine, [lit_columns(machine, line) for line in range(lines)]


def test_stars_of_cosmic_ark() -> None:
    """At the end of each line the missile moves 33, 0, 17 or 18 columns left; it is wide, then off, then normal."""
    machine, lines = stars(9)
    assert machine.state()["tia"]["cosmic_ark"]
    columns, steps = [100], (33, 0, 17, 18)
    for line in range(8):
        columns.append((columns[-1] - steps[line % 4]) % 160)
    widths = [1, 2, 0, 1, 1, 2, 0, 1, 1]
    expected = [[(c + k) % 160 for k in range(w)] for c, w in zip(columns, widths, strict=True)]
    assert lines == [sorted(line) for line in expected]


def test_stars_end_with_hmove() -> None:
    machine, lines = stars(9, end_with=W.HMOVE)
    assert not machine.state()["tia"]["cosmic_ark"]
    assert len({tuple(line) for line in lines[4:]}) == 1


@pytest.mark.parametrize("drawn", [False, True], ids=["line pending", "line drawn"])
@pytest.mark.parametrize("register", [W.NUSIZ0, W.RESM0, W.RESMP0], ids=["NUSIZ0", "RESM0", "RESMP0"])
def test_what_makes_a_star_normal_for_its_line(register: int, drawn: bool) -> None:
    """In line 2 the missile would be off; the motion continues."""
    machine, _ = stars(0)
    if drawn:
        machine.cycles = 2 * 76 + 5
        framebuffer(machine)
    if register == W.RESMP0:
        write_at(machine, 2, 7, W.RESMP0, 2)
    write_at(machine, 2, 10, register, 0)
    position = {W.NUSIZ0: 100 - 33, W.RESM0: 2, W.RESMP0: 4}[register]
    machine.cycles = 4 * 76
    assert [lit_columns(machine, line) for line in (1, 2, 3)] == [[67, 68], [position], [(position - 17) % 160]]


@pytest.mark.parametrize(
    ("old", "new", "clocks"), [(0x60, 0x60, 63), (0x70, 0x50, 63), (0x70, 0x60, 60), (0x70, 0x60, 66)]
)
def test_stars_need_the_exact_writes(old: int, new: int, clocks: int) -> None:
    machine = beam()
    machine.write(W.HMM0, old)
    write_at(machine, 0, 3, W.HMOVE)
    write_at(machine, 0, 3 + clocks // 3, W.HMM0, new)
    assert not machine.state()["tia"]["cosmic_ark"]
