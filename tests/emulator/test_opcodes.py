"""Every opcode against the model: registers, flags, cycles, and its bus accesses with their order.

The model runs on the bus of a second console. An extra or missing access, another
order or another cycle leaves that console in another state: cartridges switch banks on reads, the DPC counts reads, and
the TIA and the RIOT react to the cycle.
"""

import random
from typing import Any

import pytest
from atari_inspection import Console
from emulator.machines import JAM, NOP, console, rom, run
from emulator.model_6502 import OPCODES, Model6502, Opcode

REGISTERS = ("a", "x", "y", "sp", "pc", "n", "v", "d", "i", "z", "c")
SIZES = {"4K": 4096, "F8": 8192, "MB": 65536, "DPC": 10495, "3E": 8192, "E0": 8192, "F6SC": 16384, "FE": 8192}


class Pair:
    """A console that runs instructions itself, and one that the model uses as its bus."""

    def __init__(self, rng: random.Random, cartridge: str) -> None:
        image = rng.randbytes(SIZES[cartridge])
        self.console, self.twin = Console(image, cartridge), Console(image, cartridge)
        self.model = Model6502(self.twin)

    def prepare(self, ram: bytes, cycles: int, registers: dict[str, Any]) -> None:
        for machine in (self.console, self.twin):
            machine.ram = ram
            machine.cycles = cycles
        self.console.set_registers(**registers)
        for name, value in registers.items():
            setattr(self.model, name, value)

    def step(self) -> None:
        self.console.step()
        self.model.step()

    def differences(self) -> dict[str, tuple[Any, Any]]:
        ours, theirs = self.console.state(), self.twin.state()
        theirs["jammed"] = self.model.jammed
        ours["ram"], theirs["ram"] = self.console.ram, self.twin.ram
        ours["cartridge ram"], theirs["cartridge ram"] = self.console.cartridge_ram, self.twin.cartridge_ram
        ours |= self.console.registers
        theirs |= {name: getattr(self.model, name) for name in REGISTERS}
        return {name: (ours[name], theirs[name]) for name in ours if ours[name] != theirs[name]}

    def release(self) -> None:
        """A reset, the only exit from an illegal opcode that stops the processor."""
        self.console.reset()
        self.twin.reset()
        self.model.jammed = False


def random_registers(rng: random.Random, pc: int) -> dict[str, Any]:
    registers: dict[str, Any] = {name: rng.choice((0, 1, 0x7F, 0x80, 0xFE, 0xFF, rng.randrange(256))) for name in "axy"}
    registers |= {name: rng.random() < 0.5 for name in "nvdizc"}
    return registers | {"sp": rng.choice((0xFF, 0x80, 0x7F, 0x00, 0x02, rng.randrange(256))), "pc": pc}


def random_operand(rng: random.Random) -> bytes:
    """Low and high byte: RAM, pointers at the end of the page, TIA, RIOT, hotspots of cartridges, or anything."""
    address = rng.choice((
        rng.randrange(0x80, 0x100), 0xFF, 0x1FF, rng.randrange(0x40), rng.randrange(0x100, 0x140),
        rng.randrange(0x280, 0x298), 0xFF00 | rng.choice((0xF0, 0xF6, 0xF8, 0xF9, 0xE3, 0xFF)), 0x1000 + rng.randrange(0x100),
        rng.randrange(0x10000),
    ))  # fmt: skip
    return address.to_bytes(2, "little")


@pytest.mark.parametrize("opcode", OPCODES, ids=lambda o: f"{o.code:02X} {o.mnemonic} {o.mode}")
def test_opcode_as_model(opcode: Opcode) -> None:
    """From RAM, in random states, on cartridges that count or react to accesses."""
    rng = random.Random(opcode.code)
    for cartridge in SIZES:
        pair = Pair(rng, cartridge)
        for _ in range(30):
            ram = bytearray(rng.randbytes(128))
            place = rng.randrange(126)
            ram[place : place + 3] = bytes([opcode.code]) + random_operand(rng)
            pc = rng.choice((0x80, 0x180, 0x480, 0xE580)) + place
            registers = random_registers(rng, pc)
            pair.prepare(bytes(ram), rng.randrange(25000), registers)
            before = pair.console.cycles
            pair.step()
            assert not pair.differences(), (cartridge, registers, ram[place : place + 3].hex())
            assert pair.console.cycles >= before + opcode.cycles
            if opcode.mnemonic == "JAM":
                pair.release()


@pytest.mark.parametrize("cartridge", SIZES)
def test_runs_as_model(cartridge: str) -> None:
    """Random images, run wherever they jump, with time passing."""
    rng = random.Random(cartridge)
    for _ in range(20):
        pair = Pair(rng, cartridge)
        pair.prepare(rng.randbytes(128), 0, random_registers(rng, rng.randrange(0x10000)))
        for number in range(100):
            pair.step()
            assert not pair.differences(), (cartridge, number)
            if pair.model.jammed:
                pair.release()
                pair.prepare(pair.console.ram, 0, random_registers(rng, rng.randrange(0x10000)))


def test_jam_stops_the_processor_until_reset() -> None:
    machine = console([NOP, JAM, NOP])
    run(machine, 2)
    assert (machine.cycles, machine.registers["pc"], machine.state()["jammed"]) == (4, 0xF002, True)
    machine.step()
    machine.run_frame()
    assert (machine.cycles, machine.registers["pc"]) == (0, 0xF002)  # the frame began, nothing ran
    assert machine.state()["tia"]["partial"]
    machine.reset()
    assert not machine.state()["jammed"]
    machine.step()
    assert machine.registers["pc"] == 0xF001


def test_reset_of_the_processor() -> None:
    machine = Console(rom(start=0xF123))
    machine.set_registers(a=1, x=2, y=3, sp=4, pc=5, n=True, v=True, d=True, i=True, z=True, c=True)
    machine.reset()
    flags = dict.fromkeys("nvdizc", False)
    assert machine.registers == {"a": 0, "x": 0, "y": 0, "sp": 0xFF, "pc": 0xF123} | flags


def test_table_is_of_256_opcodes() -> None:
    """The table itself: the codes in order, the twelve that stop the processor, the one odd cost."""
    assert [opcode.code for opcode in OPCODES] == list(range(256))
    jams = [opcode.code for opcode in OPCODES if opcode.mnemonic == "JAM"]
    assert jams == [0x02, 0x12, 0x22, 0x32, 0x42, 0x52, 0x62, 0x72, 0x92, 0xB2, 0xD2, 0xF2]
    assert OPCODES[0xA7].cycles == 4  # LAX zp, one more than on the real chip
