"""The RIOT: timer, ports, RAM and their mirrors, and their state after power-on and resets."""

from typing import Any

import pytest
from atari_inspection import Console
from emulator.machines import MACHINE_FACTS, R, W, console, rom

INTERVALS = {R.TIM1T: 0, R.TIM8T: 3, R.TIM64T: 6, R.T1024T: 10}


def reads_after(timer: int, value: int, times: range | list[int], register: int = R.INTIM) -> list[int]:
    """The values of reads at these cycles after a write of a timer."""
    machine = console()
    machine.cycles = 1000
    machine.write(timer, value)
    seen = []
    for time in times:
        machine.cycles = 1000 + time
        seen.append(machine.read(register))
    return seen


def test_measured_examples() -> None:
    every_ten = range(4, 134, 10)
    assert reads_after(R.TIM8T, 2, every_ten) == [1, 0, 248, 246, 245, 244, 243, 241, 240, 239, 238, 236, 235]
    assert reads_after(R.TIM1T, 5, range(4, 44, 10)) == [1, 239, 229, 219]
    assert reads_after(R.TIM8T, 2, range(4, 44, 10), R.TIMINT) == [0, 0, 128, 128]


@pytest.mark.parametrize(("timer", "shift"), INTERVALS.items())
def test_counts_down_once_an_interval(timer: int, shift: int) -> None:
    """The timer reads one below its value at once, then counts down to 0, which the last cycle before expiry still reads."""
    interval = 1 << shift
    value = 9
    times = range(1, value * interval + 1)
    assert reads_after(timer, value, times) == [value - 1 - (time - 1) // interval for time in times]
    assert set(reads_after(timer, value, times, R.TIMINT)) == {0}


@pytest.mark.parametrize(("timer", "shift"), INTERVALS.items())
@pytest.mark.parametrize("value", [0, 1, 2, 77, 255])
def test_expiry(timer: int, shift: int, value: int) -> None:
    """One read of $FF; then TIMINT is set until the first read of INTIM, which freezes an offset."""
    end = value << shift
    # Exactly at expiry a read shows $FF and leaves TIMINT set.
    machine = console()
    machine.cycles = 500
    machine.write(timer, value)
    machine.cycles = 500 + end + 1
    assert (machine.read(R.INTIM), machine.read(R.TIMINT)) == (0xFF, 0x80)
    # The first read after expiry restarts the counting of intervals, shifted by the time of the read.
    for late in (2, 3, 200):
        machine = console()
        machine.cycles = 500
        machine.write(timer, value)
        machine.cycles = first = 500 + end + late
        assert machine.read(R.TIMINT) == 0x80
        expected = [
            (value - ((time - 501) >> shift) - (first - 500 - end)) & 0xFF for time in (first, first + 50, first + 3000)
        ]
        seen = []
        for time in (first, first + 50, first + 3000):
            machine.cycles = time
            seen.append(machine.read(R.INTIM))
            assert machine.read(R.TIMINT) == 0x00
        assert seen == expected
        machine.write(timer, 3)
        machine.cycles += (3 << shift) + 1
        assert machine.read(R.TIMINT) == 0x80


def test_reading_timint_clears_nothing() -> None:
    assert reads_after(R.TIM1T, 1, [2, 3, 4, 100], R.TIMINT) == [0x80] * 4


def test_read_in_the_cycle_of_the_write() -> None:
    """No program can read in that cycle: the elapsed cycles are then -1, and the timer counts cycles, not intervals."""
    assert reads_after(R.TIM1T, 10, [0]) == [10]
    assert reads_after(R.TIM8T, 10, [0]) == [80]


@pytest.mark.parametrize("mirror", [0x008, 0x020, 0x028, 0x040, 0x068, 0x100, 0x400, 0x800, 0x2000, 0xE000])
def test_mirrors_of_registers(mirror: int) -> None:
    machine = console()
    machine.cycles = 100
    machine.write(R.TIM64T + mirror, 20)
    machine.cycles = 200
    assert machine.state()["riot"]["shift"] == 6
    assert [machine.read(address + mirror) for address in (R.INTIM, R.INTIM + 2)] == [18, 18]
    machine.write(R.SWACNT + mirror, 0x5A)
    assert machine.read(R.SWACNT + mirror) == 0x5A
    assert machine.read(R.SWCHB + mirror) == 0x3F


def test_reads_ignore_address_bits_3_to_5() -> None:
    machine = console()
    machine.write(R.T1024T, 200)
    machine.cycles = 10
    for high in (0x280, 0x288, 0x290, 0x298, 0x2B8):
        assert [machine.read(high + low) for low in range(8)] == [0xFF, 0, 0x3F, 0, 199, 0, 199, 0]


@pytest.mark.parametrize("address", [0x284, 0x285, 0x286, 0x287, 0x28C, 0x2A4, 0x2AF])
def test_edge_detect_writes_are_ignored(address: int) -> None:
    machine = console()
    before = machine.state()
    machine.write(address, 0x55)
    assert machine.state() == before | {"bus": 0x55, "last_access_was_read": False}


@pytest.mark.parametrize("address", [0x280, 0x290, 0x294 - 4, 0x298])
def test_writes_of_ports_reach_the_ports_whatever_bit_4(address: int) -> None:
    """SWCHA in all its mirrors; a timer is not set there."""
    machine = console()
    before = machine.state()
    machine.write(address, 0x00)
    assert machine.state() == before | {"bus": 0x00, "last_access_was_read": False}
    assert machine.read(R.SWCHA) == 0xFF


def test_direction_register_has_no_influence() -> None:
    machine = console()
    machine.set_inputs(sticks=(1, 0))
    for direction in (0x00, 0xFF):
        machine.write(R.SWACNT, direction)
        machine.write(R.SWCHA, 0x00)
        assert (machine.read(R.SWACNT), machine.read(R.SWCHA)) == (direction, 0xEF)
    machine.write(R.SWCHB, 0x00)
    machine.write(R.SWBCNT, 0xFF)
    assert (machine.read(R.SWCHB), machine.read(R.SWBCNT)) == (0x3F, 0x00)


UP, DOWN, LEFT, RIGHT = 1, 2, 4, 8


@pytest.mark.parametrize(
    ("sticks", "left_first", "swapped"),
    [
        ((0, 0), 0xFF, 0xFF),
        ((UP, 0), 0xEF, 0xFE),
        ((DOWN, 0), 0xDF, 0xFD),
        ((LEFT, 0), 0xBF, 0xFB),
        ((RIGHT, 0), 0x7F, 0xF7),
        ((UP | RIGHT, DOWN | LEFT), 0x69, 0x96),
        ((0, UP), 0xFE, 0xEF),
    ],
)
def test_sticks(sticks: tuple[int, int], left_first: int, swapped: int) -> None:
    for swap, expected in ((False, left_first), (True, swapped)):
        machine = console(swap_ports=swap)
        machine.set_inputs(sticks=sticks)
        assert machine.read(R.SWCHA) == expected


@pytest.mark.parametrize(
    ("options", "pressed", "expected"),
    [
        ({"paddles": (True, False)}, 0, 0x7F),  # pin 4 of the left jack
        ({"paddles": (True, False)}, 1, 0xBF),  # pin 3
        ({"paddles": (True, False), "swap_paddles": True}, 0, 0xBF),
        ({"paddles": (True, False), "swap_paddles": True}, 1, 0x7F),
        ({"paddles": (True, True)}, 2, 0xF7),
        ({"paddles": (True, True)}, 3, 0xFB),
        ({"paddles": (True, True), "swap_paddles": True}, 3, 0xF7),
        ({"paddles": (True, True), "swap_ports": True}, 0, 0xF7),
        ({"paddles": (False, True)}, 0, 0xFF),  # no such paddle there
    ],
)
def test_paddle_buttons(options: dict[str, Any], pressed: int, expected: int) -> None:
    machine = console(**options)
    machine.set_inputs(paddle_fire=tuple(k == pressed for k in range(4)))
    assert machine.read(R.SWCHA) == expected
    machine.set_inputs()
    assert machine.read(R.SWCHA) == 0xFF


@pytest.mark.parametrize("switches", [0x3F, 0x3E, 0x3D, 0x37, 0x7F, 0xBF, 0xFC], ids=hex)
def test_console_switches(switches: int) -> None:
    """RESET bit 0, SELECT bit 1, colour bit 3, difficulties bits 6 and 7."""
    machine = console()
    assert machine.read(R.SWCHB) == 0x3F
    machine.set_inputs(switches=switches)
    assert machine.read(R.SWCHB) == switches


def test_ram_and_its_mirrors() -> None:
    machine = console()
    for offset in range(128):
        machine.write(0x80 + offset, offset ^ 0x5A)
    assert machine.ram == bytes(offset ^ 0x5A for offset in range(128))
    for mirror in (0x0180, 0x0480, 0x0580, 0x0880, 0x0D80, 0x2080, 0xED80):
        assert [machine.read(mirror + offset) for offset in (0, 1, 127)] == [0x5A, 0x5B, 0x25]
    machine.write(0x05FF, 7)
    assert machine.read(0x00FF) == 7


def test_power_on_and_resets() -> None:
    """RAM is random once; every reset draws a timer value, and leaves RAM."""
    machine = console()
    assert machine.ram.hex() == MACHINE_FACTS["ram_after_construction"]
    timers = MACHINE_FACTS["timer_of_each_reset_from_word_128"][1:]  # the first word is the construction's
    machine.ram = bytes(range(128))
    for timer in timers:
        riot = machine.state()["riot"]
        assert riot == {"timer": timer, "shift": 6, "ddr_a": 0, "set_at": 0, "irq_at": 0, "read_after_expiry": False}
        machine.write(R.SWACNT, 1)
        machine.write(R.TIM1T, 2)
        machine.cycles = 12345
        machine.read(R.INTIM)
        machine.reset()
        assert machine.cycles == 0
    assert machine.ram == bytes(range(128))


def test_timer_goes_on_from_frame_to_frame() -> None:
    """The beginning of a frame only changes the origin of the cycle count."""
    machine = console()
    machine.write(R.T1024T, 100)
    machine.cycles = 30000
    before = machine.read(R.INTIM)
    machine.start_frame()
    assert machine.cycles == 0
    assert machine.read(R.INTIM) == before == 70
    machine.cycles = 30000
    machine.start_frame()
    machine.cycles = 1024 * 100 + 50 - 60000
    assert machine.read(R.TIMINT) == 0x80
    frozen = machine.read(R.INTIM)
    machine.start_frame()
    machine.cycles = 1024
    assert machine.read(R.INTIM) == frozen - 1


def test_random_words_of_cartridge_ram_come_after_the_timer() -> None:
    machine = Console(rom(banks=2), "F8SC")
    words = MACHINE_FACTS["words_128_to_139"]
    assert machine.state()["riot"]["timer"] == 25 + words[1] % 75
    assert list(machine.cartridge_ram[:10]) == [word & 0xFF for word in words[2:]]
    assert machine.state()["random_words"] == 128 + 1 + 1 + 128
    first = machine.cartridge_ram
    machine.reset()
    assert machine.cartridge_ram != first
    assert machine.state()["random_words"] == 128 + 1 + 2 * (1 + 128)


def test_bus_keeps_the_last_byte() -> None:
    machine = console()
    machine.write(0x80, 0xAB)
    assert machine.state()["bus"] == 0xAB
    assert machine.read(0x0E) == 0xAB & 0x3F
    machine.read(R.SWCHB)
    assert machine.read(0x0F) == 0x3F
    machine.write(W.COLUBK, 0x31)
    assert machine.read(0x0E) == 0x31
