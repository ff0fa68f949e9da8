"""The TIA's input ports: fire buttons, and paddles, whose capacitors charge."""

from typing import Any

import pytest
from atari_inspection import Console
from emulator.machines import R, W, console

BUTTONS = (R.INPT4, R.INPT5)
POTS = (R.INPT0, R.INPT1, R.INPT2, R.INPT3)
CENTRE = 408823

# Cycles that a resistance needs to charge, as measured.
NEEDED = {27450: 522, 408823: 7783, 411225: 7829, 513725: 9781, 790196: 15045, 795000: 15136, 1000000: 19040}


def bits(machine: Console, ports: tuple[int, ...]) -> list[int]:
    """Bit 7 of each port; bit 6 is never driven."""
    values = []
    for port in ports:
        machine.write(0x80, 0x00)
        values.append(machine.read(port))
    assert not any(value & 0x7F for value in values)
    return [value >> 7 for value in values]


@pytest.mark.parametrize("swap", [False, True])
def test_fire_buttons(swap: bool) -> None:
    machine = console(swap_ports=swap)
    assert bits(machine, BUTTONS) == [1, 1]
    machine.set_inputs(fire=(True, False))
    assert bits(machine, BUTTONS) == ([1, 0] if swap else [0, 1])
    machine.set_inputs(fire=(True, True))
    assert bits(machine, BUTTONS) == [0, 0]
    machine.write(W.VBLANK, 0x40)  # there is no latch
    machine.set_inputs()
    assert bits(machine, BUTTONS) == [1, 1]


def test_joysticks_have_no_resistance() -> None:
    machine = console()
    machine.set_inputs(resistances=(0, 0, 0, 0))
    machine.cycles = 100_000
    assert bits(machine, POTS) == [0, 0, 0, 0]


def test_paddles_have_no_fire_button_there() -> None:
    machine = console(paddles=(True, False))
    machine.set_inputs(fire=(True, True), paddle_fire=(True, True, True, True))
    assert bits(machine, BUTTONS) == [1, 0]


def dumped(resistances: tuple[int, int, int, int], **options: Any) -> Console:
    """The capacitors empty at cycle 1000."""
    machine = console(**options)
    machine.set_inputs(resistances=resistances)
    machine.write(W.VBLANK, 0x80)
    machine.cycles = 1000
    machine.write(W.VBLANK, 0x00)
    return machine


@pytest.mark.parametrize(("resistance", "needed"), NEEDED.items())
def test_charging_time(resistance: int, needed: int) -> None:
    machine = dumped((resistance, 0, 0, 0), paddles=(True, False))
    machine.cycles = 1000 + needed
    assert bits(machine, POTS) == [0, 1, 0, 0]
    machine.cycles += 1
    assert bits(machine, POTS) == [1, 1, 0, 0]


@pytest.mark.parametrize(
    ("options", "port_of_paddle"),
    [
        ({"paddles": (True, True)}, [0, 1, 2, 3]),
        ({"paddles": (True, True), "swap_paddles": True}, [1, 0, 3, 2]),
        ({"paddles": (True, True), "swap_ports": True}, [2, 3, 0, 1]),
        ({"paddles": (True, False)}, [0, 1, None, None]),
        ({"paddles": (False, True)}, [None, None, 2, 3]),
        ({"paddles": (True, False), "swap_ports": True}, [2, 3, None, None]),
    ],
)
def test_which_paddle_is_read_where(options: dict[str, Any], port_of_paddle: list[int | None]) -> None:
    for paddle, port in enumerate(port_of_paddle):
        resistances = [CENTRE] * 4
        resistances[paddle] = 27450
        machine = dumped(tuple(resistances), **options)  # type: ignore[arg-type]
        machine.cycles = 1000 + 600
        assert bits(machine, POTS) == [int(k == port) for k in range(4)]


def test_dumping_empties_all_but_what_has_no_resistance() -> None:
    machine = console(paddles=(True, True))
    machine.set_inputs(resistances=(0, CENTRE, 1, 0))
    machine.cycles = 20000
    assert bits(machine, POTS) == [1, 1, 1, 1]
    machine.write(W.VBLANK, 0xC2)
    machine.cycles = 60000
    assert bits(machine, POTS) == [1, 0, 0, 1]


def test_only_the_edges_of_bit_7_count() -> None:
    machine = dumped((27450, 0, 0, 0), paddles=(True, False))
    machine.cycles = 1400
    machine.write(W.VBLANK, 0x42)  # bit 7 is still off, so charging does not restart
    machine.cycles = 1523
    assert bits(machine, POTS[:1]) == [1]
    machine.write(W.VBLANK, 0x80)
    machine.cycles = 1600
    machine.write(W.VBLANK, 0x82)
    assert bits(machine, POTS[:1]) == [0]
    machine.cycles = 2000
    machine.write(W.VBLANK, 0x02)
    machine.cycles = 2522
    assert bits(machine, POTS[:1]) == [0]
    machine.cycles = 2523
    assert bits(machine, POTS[:1]) == [1]


def test_what_was_charged_in_an_earlier_frame_reads_as_empty() -> None:
    """The comparison is unsigned: a time before the beginning of the frame counts as far in the future."""
    machine = dumped((27450, 0, 0, 0), paddles=(True, False))
    machine.cycles = 19912
    assert bits(machine, POTS[:1]) == [1]
    machine.start_frame()
    for cycles in (0, 5000, 19000):
        machine.cycles = cycles
        assert bits(machine, POTS[:1]) == [0]
    # With a dump shortly before the beginning of the frame, the time of full charge is in the frame.
    machine = dumped((27450, 0, 0, 0), paddles=(True, False))
    machine.cycles = 1300
    machine.start_frame()
    for cycles, charged in ((222, 0), (223, 1), (19000, 1)):
        machine.cycles = cycles
        assert bits(machine, POTS[:1]) == [charged]


def test_reset_ends_dumping() -> None:
    machine = console(paddles=(True, False))
    machine.set_inputs(resistances=(27450, 27450, 0, 0))
    machine.write(W.VBLANK, 0x80)
    machine.reset()
    assert bits(machine, POTS[:2]) == [0, 0]
    machine.cycles = 523
    assert bits(machine, POTS[:2]) == [1, 1]
