"""The bus accesses of one instruction, their order and their times, in the cases that games for the 2600 depend on."""

import random

import pytest
from atari_inspection import Console, Processor
from emulator.machines import R, W, console, rom, run
from emulator.model_6502 import OPCODES, Model6502, Opcode


def cycles_of(program: list[int], start: int = 0xF000, **registers: int | bool) -> int:
    """The cost of the first instruction of a program."""
    machine = Console(rom(program, start=start), "4K")
    machine.set_registers(**registers)
    machine.step()
    return int(machine.cycles)


@pytest.mark.parametrize(
    ("program", "registers", "cycles"),
    [
        ([0xBD, 0x80, 0xF0], {"x": 0x7F}, 4),  # LDA $F080,X
        ([0xBD, 0x80, 0xF0], {"x": 0x80}, 5),
        ([0xB9, 0xFF, 0xF0], {"y": 0x01}, 5),  # LDA $F0FF,Y
        ([0xBE, 0xFF, 0xF0], {"y": 0x00}, 4),  # LDX $F0FF,Y
        ([0xBD, 0xF0, 0xFF], {"x": 0x10}, 5),  # LDA $FFF0,X: beyond the last page
        ([0x9D, 0x80, 0x00], {"x": 0x7F}, 5),  # STA $0080,X: always the same
        ([0x9D, 0x80, 0x01], {"x": 0x80}, 5),
        ([0xFE, 0x80, 0x01], {"x": 0x00}, 7),  # INC $0180,X
        ([0xFE, 0xF0, 0x00], {"x": 0x90}, 7),
        ([0x1C, 0x80, 0xF0], {"x": 0x80}, 5),  # NOP $F080,X
        ([0xBF, 0x80, 0xF0], {"y": 0x80}, 5),  # LAX $F080,Y
        ([0xBB, 0x80, 0xF0], {"y": 0x80}, 5),  # LAS $F080,Y
        ([0xA7, 0x80], {}, 4),  # LAX zp
        ([0xD0, 0x10], {"z": True}, 2),  # BNE, not taken
        ([0xD0, 0x10], {"z": False}, 3),  # taken
        ([0xD0, 0xF0], {"z": False}, 4),  # taken, back into the page before
    ],
)
def test_penalties(program: list[int], registers: dict[str, int], cycles: int) -> None:
    assert cycles_of(program, **registers) == cycles


def test_branch_penalty_counts_from_the_next_instruction() -> None:
    """From $F0FD, the next instruction is at $F0FF: a jump of 0 stays in its page, a jump of 1 does not."""
    assert cycles_of([0xF0, 0x00], start=0xF0FD, z=True) == 3
    assert cycles_of([0xF0, 0x01], start=0xF0FD, z=True) == 4
    assert cycles_of([0xF0, 0xFF], start=0xF0FE, z=True) == 4  # from $F100 back to $F0FF
    assert cycles_of([0xF0, 0x00], start=0xF0FE, z=True) == 3


@pytest.mark.parametrize(("opcode", "register"), [(0xA1, "x"), (0xB1, "y")], ids=["LDA (zp,X)", "LDA (zp),Y"])
def test_pointer_at_the_end_of_page_zero(opcode: int, register: str) -> None:
    """The high byte of the pointer comes from $0100, a collision register: its low six bits are those of the low byte."""
    machine = console([opcode, 0xFF])
    machine.set_registers(x=0, y=0)
    machine.write(0xFF, 0x95)
    machine.step()
    assert machine.registers["a"] == 0xEA  # from $1595, a byte of the cartridge
    machine = console([opcode, 0xFF])
    machine.write(0xFF, 0x80)  # $0080: the low six bits of $80 are 0
    machine.write(0x80, 0x5A)
    machine.step()
    assert machine.registers["a"] == 0x5A
    # The cartridge 3F answers at $0000, but not at $0100.
    machine = Console(rom([opcode, 0xFF], banks=2), "3F")
    machine.set_registers(x=0, y=0)
    assert machine.read(0x0000) == opcode
    machine.write(0xFF, 0x80)
    machine.write(0x80, 0x5A)
    machine.step()
    assert machine.registers["a"] == 0x5A


def test_pointers_in_page_zero_wrap_before_that() -> None:
    machine = console([0xA1, 0xF0])  # LDA ($F0,X)
    machine.set_registers(x=0x95)  # $F0 + $95 is $85
    machine.write(0x85, 0x90)
    machine.write(0x86, 0x00)
    machine.write(0x90, 0x77)
    machine.step()
    assert machine.registers["a"] == 0x77


def test_jmp_indirect_does_not_leave_the_page() -> None:
    machine = console([0x6C, 0xFF, 0x00])  # JMP ($00FF): high byte at $0000, the TIA, not at $0100
    machine.write(0xFF, 0x34)
    machine.step()
    assert machine.registers["pc"] == 0x3434
    image = bytearray(rom([0x6C, 0xFF, 0xF1]))
    image[0x1FF], image[0x100], image[0x200] = 0x21, 0xF4, 0xF5
    machine = Console(bytes(image), "4K")
    machine.step()
    assert machine.registers["pc"] == 0xF421


@pytest.mark.parametrize(
    ("program", "accesses"),
    [
        ([0xAD, 0xF0, 0x1F], 1),  # LDA: one read
        ([0x8D, 0xF0, 0x1F], 1),  # STA: one write
        ([0xEE, 0xF0, 0x1F], 2),  # INC: one read, one write
        ([0x0F, 0xF0, 0x1F], 2),  # SLO
        ([0x0C, 0xF0, 0x1F], 1),  # NOP abs does read
        ([0xBD, 0xF0, 0x1E], 0),  # LDA $1EF0,X with X = $FF: nothing at $1EEF or $1FF0 on the way to $1FEF
        ([0xBD, 0xF1, 0x1E], 1),  # to $1FF0 itself: no read at $1EF0 first, one at $1FF0
        ([0x9D, 0xF1, 0x1E], 1),
        ([0x6C, 0xF0, 0x1F], 1),  # JMP ($1FF0)
        ([0x4C, 0xF0, 0x1F], 0),  # JMP $1FF0 does not read its target
        ([0x20, 0xF0, 0x1F], 0),  # JSR neither
    ],
)
def test_number_of_accesses(program: list[int], accesses: int) -> None:
    """The MB cartridge goes to the next bank at each access of $1FF0."""
    machine = Console(rom(program, banks=16), "MB")
    machine.set_registers(x=0xFF)
    before = machine.state()["cart"]["bank"]
    machine.step()
    assert (machine.state()["cart"]["bank"] - before) % 16 == accesses


def test_rts_reads_the_byte_before_its_target() -> None:
    """RTS reads through the cartridge: a return to the address after a hotspot switches banks."""
    machine = Console(rom([0x60], banks=16), "MB")
    before = machine.state()["cart"]["bank"]
    machine.set_registers(sp=0xF0)
    machine.write(0xF1, 0xF0)
    machine.write(0xF2, 0x1F)
    machine.step()
    assert machine.registers["pc"] == 0x1FF1
    assert machine.state()["cart"]["bank"] == before + 1


def test_operand_and_opcode_fetches_reach_the_cartridge() -> None:
    """Executing at a hotspot switches the bank; the fetched byte comes from the new bank."""
    first, second = bytearray(rom()), bytearray(rom())
    second[0xFF9:0xFFB] = [0xA9, 0x42]  # LDA #$42
    machine = Console(bytes(first + second), "F8")
    machine.read(0x1FF8)
    machine.set_registers(pc=0x1FF9)
    machine.step()
    assert machine.registers["a"] == 0x42
    assert machine.state()["cart"]["bank"] == 1


def test_stack_wraps_and_mirrors() -> None:
    machine = console([0x48, 0x48, 0x68])  # PHA PHA PLA
    machine.set_registers(a=0x9D, sp=0x80)
    machine.step()
    assert machine.ram[0] == 0x9D
    assert machine.registers["sp"] == 0x7F
    machine.set_registers(sp=0x00)
    machine.step()  # to $0100, which is VSYNC
    assert machine.registers["sp"] == 0xFF
    machine.set_registers(sp=0xFF)
    machine.write(0x00, 0)
    machine.step()  # from $0100
    assert machine.registers["sp"] == 0x00


def test_pulls_from_tia_space() -> None:
    """PLA reads twice: the first read returns the low bits of the opcode, the second those of the first."""
    machine = console([0x68])
    machine.set_registers(sp=0x3D)
    machine.step()
    assert machine.registers["a"] == 0x68 & 0x3F
    machine = console([0x28])  # PLP: $28 & $3F has D alone among the flags
    machine.set_registers(sp=0x3D, n=True, c=True)
    machine.step()
    flags = {name: machine.registers[name] for name in "nvdizc"}
    assert flags == {"n": False, "v": False, "d": True, "i": False, "z": False, "c": False}


def test_pushes_into_tia_space() -> None:
    """PHA and PHP switch missiles on, as many games do; JSR writes the high byte first."""
    machine = console([0x48, 0x08, 0x20, 0x10, 0xF0])  # PHA PHP JSR
    machine.set_registers(a=0x02, sp=W.ENABL, z=True)
    run(machine, 2)
    tia = machine.state()["tia"]
    assert (tia["enabl"], tia["enam"]) == (True, [0, 1])
    machine.set_registers(sp=W.GRP1)
    machine.step()  # $F004: $F0 to GRP1, then $04 to GRP0, which copies GRP1
    tia = machine.state()["tia"]
    assert (tia["grp"], tia["old_grp"]) == ([0x04, 0xF0], [0x00, 0xF0])


def test_brk_pushes_and_continues_at_its_vector() -> None:
    image = bytearray(rom([0x00, 0xFF]))
    image[-2:] = b"\x34\xf2"
    machine = Console(bytes(image), "4K")
    machine.set_registers(sp=0xFF, n=True, v=False, d=True, i=False, z=False, c=True)
    machine.step()
    assert machine.ram[-3:] == bytes([0b10111001, 0x02, 0xF0])
    assert machine.registers["pc"] == 0xF234
    assert machine.registers["i"]
    assert machine.registers["d"]  # decimal mode stays
    assert machine.cycles == 7


def test_interrupt_flag_has_no_effect_and_b_no_place() -> None:
    machine = console([0x40])  # RTI
    machine.write(0xFD, 0b00110000)
    machine.write(0xFE, 0x00)
    machine.write(0xFF, 0xF3)
    machine.set_registers(sp=0xFC, n=True, v=True, d=True, i=True, z=True, c=True)
    machine.step()
    assert machine.registers["pc"] == 0xF300
    assert not any(machine.registers[name] for name in "nvdizc")


@pytest.mark.parametrize(
    ("program", "low_bits"),
    [
        ([0xA5, 0x0E], 0x0E),  # zp: the operand
        ([0xB5, 0x2D], 0x2D),  # zpx: the operand before indexing
        ([0xAD, 0x0E, 0x00], 0x00),  # abs: the high byte
        ([0xAD, 0x0E, 0x25], 0x25),
        ([0xBD, 0x2D, 0x25], 0x25),  # absx
        ([0xA1, 0x61], 0x21),  # indx: the high byte of the pointer
        ([0xB1, 0x82], 0x21),  # indy
    ],
)
def test_undriven_bits_of_the_tia(program: list[int], low_bits: int) -> None:
    machine = console(program)
    machine.set_registers(x=0x21, y=0x00)
    machine.write(0x82, 0x0E)
    machine.write(0x83, 0x21)  # $210E: register 14 of the TIA drives nothing
    machine.step()
    assert machine.registers["a"] == low_bits


def test_accesses_happen_at_the_end_of_the_instruction() -> None:
    """A timer that counts cycles measures the access: LDA absolute takes 4 cycles, 5 with a page crossing."""
    for program, x, left in (([0xAD, 0x84, 0x02], 0, 100 - 4), ([0xBD, 0xF4, 0x01], 0x90, 100 - 5)):
        machine = console(program)
        machine.write(R.TIM1T, 100)
        machine.set_registers(x=x)
        machine.step()
        assert machine.registers["a"] == left


def test_wsync_waits_for_the_next_line() -> None:
    machine = console([0x85, W.WSYNC, 0x85, W.WSYNC])
    machine.start_frame()
    machine.step()
    assert machine.cycles == 76
    machine.cycles = 76 * 5 - 3
    machine.step()  # ends exactly at the beginning of a line, so WSYNC does not wait
    assert machine.cycles == 76 * 5


@pytest.mark.parametrize("opcode", [0xE6, 0x06, 0xC7], ids=["INC", "ASL", "DCP"])
def test_wsync_by_read_modify_write_waits_once(opcode: int) -> None:
    machine = console([opcode, W.WSYNC])
    machine.start_frame()
    machine.step()
    assert machine.cycles == 76


def test_wsync_does_not_wait_after_a_write() -> None:
    """The first push of JSR waits. Its second does not wait, nor do the second and third of BRK."""
    for sp, cycles in ((W.WSYNC, 76), (W.WSYNC + 1, 6)):
        machine = console([0x20, 0x00, 0xF1])
        machine.start_frame()
        machine.set_registers(sp=sp)
        machine.step()
        assert machine.cycles == cycles
    for sp, cycles in ((W.WSYNC, 76), (W.WSYNC + 1, 7), (W.WSYNC + 2, 7)):
        machine = console([0x00])
        machine.start_frame()
        machine.set_registers(sp=sp)
        machine.step()
        assert machine.cycles == cycles


def test_program_counter_wraps_and_keeps_its_high_bits() -> None:
    """The program counter has 16 bits: the cartridge FE distinguishes $F000 from $D000."""
    image = bytes([0x10]) * 4096 + bytes([0x20]) * 4096
    machine = Console(image, "FE")
    assert [machine.read(address) for address in (0xF000, 0xD000, 0x1000, 0x3000)] == [0x10, 0x20, 0x20, 0x10]
    machine = console()
    machine.set_registers(pc=0xFFFF, z=False)
    machine.step()  # the high byte of the vector, $F0: BEQ with its operand at $0000
    assert machine.registers["pc"] == 0x0001
    machine = console()
    machine.write(0x80, 0xEA)
    machine.set_registers(pc=0x2080)
    machine.step()
    assert machine.registers["pc"] == 0x2081


class RecordingBus:
    """64 KiB of memory and nothing else. `accesses` are all reads and writes, each with its cycle."""

    def __init__(self, memory: bytes) -> None:
        self.memory = bytearray(memory)
        self.cycles = 0
        self.accesses: list[tuple[str, int, int, int]] = []

    def read(self, address: int) -> int:
        value = self.memory[address]
        self.accesses.append(("read", address, value, self.cycles))
        return value

    def write(self, address: int, value: int) -> None:
        self.memory[address] = value
        self.accesses.append(("write", address, value, self.cycles))


@pytest.mark.parametrize("opcode", OPCODES, ids=lambda o: f"{o.code:02X} {o.mnemonic} {o.mode}")
def test_processor_alone_accesses_the_bus_as_the_model(opcode: Opcode) -> None:
    """Without a console: no chip is needed, and every access is compared, not only its effect on a chip."""
    rng = random.Random(opcode.code)
    memory = rng.randbytes(0x10000)
    for _ in range(20):
        buses = [RecordingBus(memory), RecordingBus(memory)]
        processor, model = Processor(buses[0]), Model6502(buses[1])
        pc = rng.randrange(0x10000)
        registers = {name: rng.randrange(256) for name in ("a", "x", "y", "sp")} | {"pc": pc}
        registers |= {name: rng.random() < 0.5 for name in "nvdizc"}
        processor.set_registers(**registers)
        for name, value in registers.items():
            setattr(model, name, value)
        for bus in buses:
            bus.memory[pc] = opcode.code
        processor.step()
        model.step()
        assert buses[0].accesses == buses[1].accesses, registers
        assert buses[0].cycles == buses[1].cycles
        assert processor.registers == {name: getattr(model, name) for name in processor.registers}
