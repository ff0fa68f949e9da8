"""ADC, SBC and ARR over all operands, accumulators and carries, binary and decimal, invalid digits included."""

import hashlib
from collections.abc import Iterator

import pytest
from atari_inspection import Console
from emulator.machines import MACHINE_FACTS, console
from emulator.model_6502 import Model6502

CODES = {"adc": 0x69, "sbc": 0xE9, "arr": 0x6B}


def results(machine: Console, operation: str, decimal: bool) -> Iterator[tuple[int, int, int, dict[str, int]]]:
    """(carry, operand, accumulator, registers afterwards) of all cases; A innermost."""
    for carry in (0, 1):
        for operand in range(256):
            machine.write(0x80, CODES[operation])
            machine.write(0x81, operand)
            for a in range(256):
                machine.set_registers(a=a, pc=0x80, n=False, v=False, d=decimal, i=False, z=False, c=bool(carry))
                machine.step()
                yield carry, operand, a, machine.registers


def status(flags: dict[str, int]) -> int:
    """The status register; the bits 4 and 5 are set."""
    high = flags["n"] << 7 | flags["v"] << 6 | 0x30 | flags["d"] << 3
    return high | flags["i"] << 2 | flags["z"] << 1 | flags["c"]


def digits(byte: int) -> int | None:
    """The number of two decimal digits, None if one is no digit."""
    return byte // 16 * 10 + byte % 16 if byte < 0xA0 and byte % 16 < 10 else None


@pytest.mark.parametrize("decimal", [False, True], ids=["binary", "decimal"])
@pytest.mark.parametrize("operation", CODES)
def test_all_cases(operation: str, decimal: bool) -> None:
    """Equal to ale-py, by check sum, and to the model, case by case; with valid digits, decimal mode is arithmetic."""
    model = Model6502(console())
    compute, seen = getattr(model, operation), bytearray()
    numbers = [digits(byte) for byte in range(256)]
    for carry, operand, a, after in results(console(), operation, decimal):
        model.a, model.c, model.d = a, carry == 1, decimal
        compute(operand)
        flags = (model.n, model.v, model.z, model.c)
        assert (after["a"], (after["n"], after["v"], after["z"], after["c"])) == (model.a, flags), (carry, operand, a)
        seen += bytes((after["a"], status(after)))
        first, second = numbers[a], numbers[operand]
        if decimal and operation != "arr" and first is not None and second is not None:
            total = first + second + carry if operation == "adc" else first - second - (1 - carry)
            in_carry = total >= 100 if operation == "adc" else total >= 0
            assert (numbers[after["a"]], after["c"]) == (total % 100, in_carry), (carry, operand, a)
    expected = MACHINE_FACTS["alu_sha256"][f"{operation}_{'decimal' if decimal else 'binary'}"]
    assert hashlib.sha256(seen).hexdigest() == expected
