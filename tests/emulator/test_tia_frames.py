"""How frames begin and end, which lines the framebuffer has, and its content when a frame ends early."""

import numpy as np
import pytest
from atari_inspection import Console
from emulator.machines import JAM, W, beam, console, framebuffer, write_at

WSYNC = [0x85, W.WSYNC]


def store(value: int, register: int) -> list[int]:
    return [0xA9, value, 0x85, register]


def jump(address: int) -> list[int]:
    return [0x4C, address & 0xFF, address >> 8]


def lines(count: int) -> list[int]:
    """A loop of `count` WSYNCs: LDX #count, STA WSYNC, DEX, BNE."""
    return [0xA2, count, *WSYNC, 0xCA, 0xD0, 0xFB]


def frame_program(count: int, body: list[int] | None = None) -> list[int]:
    """Frames of this many lines: three of VSYNC, the body, which must take less than a line, the rest."""
    program = [*store(2, W.VSYNC), *WSYNC, *WSYNC, *WSYNC, *store(0, W.VSYNC), *(body or [])]
    left = count - 3
    while left > 0:
        program += lines(min(left, 200))
        left -= 200
    return program + jump(0xF000)


def ended(machine: Console) -> bool:
    return bool(machine.state()["stop"])


# -- VSYNC


@pytest.mark.parametrize(("on", "ends"), [(75, False), (76, True), (77, True), (1000, True)])
def test_frame_ends_when_vsync_goes_off_after_a_line(on: int, ends: bool) -> None:
    machine = beam()
    write_at(machine, 2, 17, W.VSYNC, 0x02)
    assert not ended(machine)
    machine.cycles += on
    machine.write(W.VSYNC, 0xFD)  # bit 1 alone counts
    assert ended(machine) == ends


def test_each_write_of_vsync_starts_the_wait_anew_and_switching_off_early_does_not_end_it() -> None:
    machine = beam()
    machine.write(W.VSYNC, 2)
    machine.cycles = 70
    machine.write(W.VSYNC, 2)
    machine.cycles = 100
    machine.write(W.VSYNC, 0)
    assert not ended(machine)
    machine.cycles = 145
    machine.write(W.VSYNC, 0)
    assert not ended(machine)
    machine.cycles = 146
    machine.write(W.VSYNC, 0)
    assert ended(machine)


def test_vsync_that_is_never_on_ends_nothing() -> None:
    machine = beam()
    for cycle in (0, 76, 10000):
        machine.cycles = cycle
        machine.write(W.VSYNC, 0)
    assert not ended(machine)


@pytest.mark.parametrize("count", [200, 262, 280])
def test_frames_of_a_program(count: int) -> None:
    machine = console(frame_program(count))
    machine.run_frame()
    for _ in range(3):
        machine.run_frame()
        tia = machine.state()["tia"]
        assert (tia["current_line"], tia["last_line_count"], tia["partial"]) == (count, count, False)
        assert machine.registers["pc"] == 0xF000 + 14  # after the store that switched VSYNC off


def test_phase_of_lines_goes_on_from_frame_to_frame() -> None:
    """The store of 0 ends five cycles into its line, and there the next frame begins."""
    machine = console(frame_program(100))
    machine.run_frame()
    assert machine.cycles % 76 == 5
    machine.run_frame()
    assert machine.cycles == 100 * 76
    machine.start_frame()
    assert (machine.cycles, machine.state()["tia"]["frame_start"]) == (0, -15)
    machine.set_registers(pc=0xF004)
    machine.step()  # WSYNC
    assert machine.cycles == 76 - 5


# -- limits


@pytest.mark.parametrize(("pal", "last"), [(False, 290), (True, 342)])
def test_line_limit(pal: bool, last: int) -> None:
    """After the last line, any TIA write ends the frame and takes effect; a read does not end it."""
    machine = console(pal=pal)
    machine.start_frame()
    write_at(machine, last, 75, W.COLUBK, 0x22)
    assert not ended(machine)
    machine.cycles = 76 * (last + 1)
    machine.read(0x00)
    machine.write(0x80, 0)
    assert not ended(machine)
    machine.write(0x3F, 0x00)
    assert ended(machine)
    write_at(machine, last + 1, 10, W.COLUBK, 0x44)
    assert machine.state()["tia"]["colour"][3] == 0x44


@pytest.mark.parametrize(("pal", "count"), [(False, 291), (True, 343)])
def test_program_without_vsync(pal: bool, count: int) -> None:
    """The frame ends with the first TIA write after the limit, here a WSYNC, which still waits."""
    machine = console([*WSYNC, *jump(0xF000)], pal=pal)
    for _ in range(3):
        machine.run_frame()
        assert machine.scan_lines == count + 1
        assert machine.cycles == 76 * (count + 1)


def test_instruction_limit() -> None:
    """After 25,000 instructions an update ends; the next update continues the same frame."""
    machine = console([0xE6, 0x80, *jump(0xF000)])  # INC $80: 8 cycles for two instructions
    machine.ram = bytes(128)
    for update in (1, 2, 3):
        machine.run_frame()
        assert machine.cycles == update * 12500 * 8
        assert machine.ram[0] == update * 12500 % 256
        assert machine.state()["tia"]["partial"]
        assert machine.scan_lines == update * 100000 // 76


def test_reset_keeps_a_partial_frame_partial() -> None:
    """The update after the reset continues the frame. Line 0 is the first row when the beam reaches it."""
    machine = console([0xE6, 0x80, *jump(0xF000)], first_line=20, height=25)
    machine.run_frame()
    machine.reset()
    assert machine.state()["tia"]["partial"]
    write_at(machine, 3, 0, W.COLUBK, 0x1E)  # nothing is drawn above the framebuffer
    machine.cycles = 76 * 19
    assert not framebuffer(machine).any()
    write_at(machine, 22, 0, W.COLUBK, 0x44)
    machine.cycles = 76 * 60
    assert framebuffer(machine)[:, 80].tolist() == [0x1E] * 22 + [0x44] * 3


def test_illegal_opcode_greys_what_is_below_it() -> None:
    """The rows below keep the pixels of two frames ago, once, without hue and at half the luminance."""
    body = [0xA5, 0x81, 0x85, W.COLUBK, 0xA5, 0x80, 0xF0, 8, *lines(14), JAM]  # jams in line 14 unless $80 is 0
    machine = console(frame_program(60, body), first_line=10, height=10)
    for colour in (0x1A, 0x3C, 0x3A):
        machine.ram = bytes([0, colour]) + bytes(126)
        machine.run_frame()
    assert set(machine.framebuffer().ravel()) == {0x3A}
    machine.ram = bytes([1, 0x44]) + bytes(126)
    for _ in range(3):
        machine.run_frame()
        assert machine.state()["jammed"]
        assert machine.scan_lines == 14
        # The beam stopped in the blank of line 13: that row is unchanged, the rows below are grey.
        assert [set(row) for row in machine.framebuffer().tolist()] == [{0x44}] * 3 + [{0x3C}] + [{6}] * 6


def finish_frame(machine: Console, line: int) -> None:
    """Render everything, and end the frame at the beginning of a line."""
    write_at(machine, line, 0, W.VSYNC, 2)
    write_at(machine, line + 1, 0, W.VSYNC, 0)
    framebuffer(machine)


# -- the framebuffer


@pytest.mark.parametrize(("first_line", "height"), [(0, 4), (34, 210), (40, 256), (299, 1)])
def test_lines_of_the_framebuffer(first_line: int, height: int) -> None:
    machine = console(first_line=first_line, height=height)
    machine.start_frame()
    for line in range(300):
        write_at(machine, line, 0, W.COLUBK, (line + 1) << 1 & 0xFF)
    machine.cycles = 76 * 300
    assert framebuffer(machine).shape == (height, 160)
    assert framebuffer(machine)[:, 0].tolist() == [(first_line + row + 1) << 1 & 0xFF for row in range(height)]


def test_undrawn_rows_show_the_frame_before_last() -> None:
    """Two framebuffers alternate, and only a reset clears them."""
    machine = beam(height=4)
    for colour in (0x22, 0x44):
        machine.write(W.COLUBK, colour)
        finish_frame(machine, 10)
        machine.start_frame()
    machine.write(W.COLUBK, 0x66)
    machine.cycles = 2 * 76
    assert framebuffer(machine)[:, 80].tolist() == [0x66, 0x66, 0x22, 0x22]
    finish_frame(machine, 2)
    machine.start_frame()
    assert framebuffer(machine)[:, 80].tolist() == [0x44] * 4
    machine.reset()
    assert not framebuffer(machine).any()


def test_the_framebuffer_ends_at_the_beam() -> None:
    machine = beam()
    machine.write(W.COLUBK, 0x0E)
    machine.cycles = 76 + 40
    shown = framebuffer(machine)
    assert shown[1].tolist() == [0x0E] * 52 + [0] * 108
    assert not shown[2:].any()


def test_reset_clears_the_tia() -> None:
    machine = console(first_line=2, height=6)
    untouched = machine.state()["tia"]
    machine.start_frame()
    for line in range(6):
        for k, register in enumerate(register for register in range(0x2D) if register != W.WSYNC):
            write_at(machine, line, k + 1, register, 0xFF)
    assert machine.state()["tia"] != untouched
    machine.reset()
    # A reset keeps `partial` and `greyed`, which are false after `start_frame`, and the number of the next framebuffer.
    assert machine.state()["tia"] == untouched | {"current": 1}
    assert machine.cycles == 0


# -- PAL


def test_colour_loss() -> None:
    """Under PAL rules, colours are odd in and after a frame of an odd number of lines; the others never are."""
    for pal in (False, True):
        machine = console(frame_program(261), pal=pal)
        machine.run_frame()  # of four lines
        machine.run_frame()
        assert machine.state()["tia"]["last_line_count"] == 261
        machine.start_frame()
        assert machine.state()["tia"]["colour"] == [1 if pal else 0] * 4
        machine.write(W.COLUP0, 0x40)
        assert machine.state()["tia"]["colour"][0] == (0x41 if pal else 0x40)


def test_colour_loss_ends_with_an_even_frame() -> None:
    machine = console(frame_program(260), pal=True)
    for _ in range(3):
        machine.run_frame()
    machine.write(W.COLUBK, 0x9F)
    machine.start_frame()
    assert machine.state()["tia"]["colour"] == [0, 0, 0, 0x9E]


def test_the_framebuffer_must_fit() -> None:
    for first_line, height in ((-1, 10), (100, 201), (0, 0)):
        with pytest.raises(ValueError, match="within 300 lines"):
            console(first_line=first_line, height=height)


def test_ordinary_frame_is_what_its_lines_say() -> None:
    """A whole program: 262 lines, COLUBK set line by line."""
    body = [0xA2, 0x00, 0x86, W.COLUBK, 0xE8, 0xE8]  # LDX #0; STX COLUBK; INX INX
    program = [*store(2, W.VSYNC), *WSYNC, *WSYNC, *WSYNC, *store(0, W.VSYNC), *body]
    line = [*WSYNC, 0x86, W.COLUBK, 0xE8, 0xE8, 0xE0, 0xFE]  # ... CPX #$FE
    program += [*line, 0xD0, 0x100 - len(line) - 2]  # BNE
    machine = console(program + jump(0xF000))
    machine.run_frame()
    machine.run_frame()
    np.testing.assert_array_equal(machine.framebuffer()[:90, 0], 2 * np.arange(34, 124, dtype=np.uint8))
