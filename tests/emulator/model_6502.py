"""A small model of the 6507 of ale-py, with one Python function for each instruction.

The table `facts/opcodes.csv` drives the model. It reads and writes the bus that its constructor gets, and
advances the cycle counter of that bus: first by the whole base cost, then by each penalty before the access it belongs
to.
"""

import csv
from dataclasses import dataclass
from typing import Protocol

from emulator.machines import FACTS


class Bus(Protocol):
    cycles: int

    def read(self, address: int) -> int: ...
    def write(self, address: int, value: int) -> None: ...


@dataclass(frozen=True)
class Opcode:
    code: int
    mnemonic: str
    mode: str
    access: str
    length: int
    cycles: int
    page_penalty: bool


def _table() -> list[Opcode]:
    with (FACTS / "opcodes.csv").open() as file:
        return [
            Opcode(int(row["opcode"], 16), row["mnemonic"], row["mode"], row["access"], int(row["length"]),
                   int(row["cycles"]), row["page_penalty"] == "1")
            for row in csv.DictReader(file)
        ]  # fmt: skip


OPCODES = _table()

BRANCHES = {"BPL": ("n", False), "BMI": ("n", True), "BVC": ("v", False), "BVS": ("v", True),
            "BCC": ("c", False), "BCS": ("c", True), "BNE": ("z", False), "BEQ": ("z", True)}  # fmt: skip
FLAG_CHANGES = {"CLC": ("c", False), "SEC": ("c", True), "CLI": ("i", False), "SEI": ("i", True),
                "CLD": ("d", False), "SED": ("d", True), "CLV": ("v", False)}  # fmt: skip
TRANSFERS = {"TAX": ("a", "x"), "TAY": ("a", "y"), "TXA": ("x", "a"), "TYA": ("y", "a"), "TSX": ("sp", "x")}
STEPS = {"INX": ("x", 1), "INY": ("y", 1), "DEX": ("x", -1), "DEY": ("y", -1)}
LOADS = {"LDA": "a", "LDX": "x", "LDY": "y", "LAX": "ax", "LAS": "axs"}
COMPARISONS = {"CMP": "a", "CPX": "x", "CPY": "y"}


class Model6502:
    """Registers a, x, y, sp, pc and flags n, v, d, i, z, c, as attributes."""

    def __init__(self, bus: Bus) -> None:
        self.bus = bus
        self.a = self.x = self.y = self.sp = self.pc = 0
        self.n = self.v = self.d = self.i = self.z = self.c = False
        self.jammed = False

    def step(self) -> None:
        """Run one instruction."""
        opcode = OPCODES[self.fetch()]
        self.bus.cycles += opcode.cycles
        if opcode.mode == "rel":
            self.branch(*BRANCHES[opcode.mnemonic])
        elif opcode.mode == "acc":
            self.a = self.nz(self.shifted(opcode.mnemonic, self.a))
        elif opcode.access == "":
            self.control(opcode)
        else:
            address = self.address(opcode)
            if opcode.access == "r":
                self.use(opcode.mnemonic, self.bus.read(address))
            elif opcode.access == "w":
                self.bus.write(address, self.stored(opcode.mnemonic, address))
            else:
                value = self.shifted(opcode.mnemonic, self.bus.read(address))
                self.bus.write(address, value)
                self.afterwards(opcode.mnemonic, value)

    # -- the bus

    def fetch(self) -> int:
        byte = self.bus.read(self.pc)
        self.pc = (self.pc + 1) & 0xFFFF
        return byte

    def word(self) -> int:
        low = self.fetch()
        return low | self.fetch() << 8

    def push(self, byte: int) -> None:
        self.bus.write(0x100 + self.sp, byte)
        self.sp = (self.sp - 1) & 0xFF

    def pull(self) -> int:
        self.sp = (self.sp + 1) & 0xFF
        return self.bus.read(0x100 + self.sp)

    def address(self, opcode: Opcode) -> int:
        mode = opcode.mode
        if mode == "imm":
            self.pc = (self.pc + 1) & 0xFFFF
            return (self.pc - 1) & 0xFFFF
        if mode in ("zp", "zpx", "zpy"):
            return (self.fetch() + {"zp": 0, "zpx": self.x, "zpy": self.y}[mode]) & 0xFF
        if mode in ("indx", "indy"):
            pointer = self.fetch()
            if mode == "indx":
                pointer = (pointer + self.x) & 0xFF
            low = self.bus.read(pointer)
            base = low | self.bus.read(pointer + 1) << 8  # after $FF comes $0100, which is the TIA
        else:
            base = self.word()
        index = {"abs": 0, "absx": self.x, "absy": self.y, "indx": 0, "indy": self.y}[mode]
        if opcode.page_penalty and base // 256 != (base + index) // 256:
            self.bus.cycles += 1
        return (base + index) & 0xFFFF

    # -- results

    def nz(self, byte: int) -> int:
        self.n, self.z = byte >= 128, byte == 0
        return byte

    @property
    def ps(self) -> int:
        bits = [self.n, self.v, True, True, self.d, self.i, self.z, self.c]
        return int("".join(str(int(bit)) for bit in bits), 2)

    @ps.setter
    def ps(self, byte: int) -> None:
        self.n, self.v, _, _, self.d, self.i, self.z, self.c = (bit == "1" for bit in f"{byte:08b}")

    # -- operations

    def branch(self, flag: str, wanted: bool) -> None:
        offset = self.fetch()
        if getattr(self, flag) is not wanted:
            return
        target = (self.pc + (offset if offset < 128 else offset - 256)) & 0xFFFF
        self.bus.cycles += 1 if target // 256 == self.pc // 256 else 2
        self.pc = target

    def stored(self, mnemonic: str, address: int) -> int:
        high = (address >> 8) + 1
        if mnemonic == "SHS":
            self.sp = self.a & self.x
        return {
            "STA": self.a, "STX": self.x, "STY": self.y, "SAX": self.a & self.x, "SHA": self.a & self.x & high,
            "SHX": self.x & high, "SHY": self.y & high, "SHS": self.sp & high,
        }[mnemonic]  # fmt: skip

    def shifted(self, mnemonic: str, old: int) -> int:
        carry = self.c
        if mnemonic in ("ASL", "SLO", "ROL", "RLA"):
            self.c = old >= 128
            return (2 * old + (carry if mnemonic in ("ROL", "RLA") else 0)) % 256
        if mnemonic in ("LSR", "SRE", "ROR", "RRA"):
            self.c = old % 2 == 1
            return old // 2 + (128 * carry if mnemonic in ("ROR", "RRA") else 0)
        return (old + {"INC": 1, "ISB": 1, "DEC": -1, "DCP": -1}[mnemonic]) % 256

    def afterwards(self, mnemonic: str, value: int) -> None:
        if mnemonic == "SLO":
            self.a = self.nz(self.a | value)
        elif mnemonic == "RLA":
            self.a = self.nz(self.a & value)
        elif mnemonic == "SRE":
            self.a = self.nz(self.a ^ value)
        elif mnemonic == "RRA":
            self.adc(value)
        elif mnemonic == "ISB":
            self.sbc(value)
        elif mnemonic == "DCP":
            self.compare(self.a, value)
        else:
            self.nz(value)

    def use(self, mnemonic: str, operand: int) -> None:
        if mnemonic in LOADS:
            value = self.nz(operand & self.sp if mnemonic == "LAS" else operand)
            for register in LOADS[mnemonic]:
                setattr(self, "sp" if register == "s" else register, value)
        elif mnemonic in COMPARISONS:
            self.compare(getattr(self, COMPARISONS[mnemonic]), operand)
        else:
            getattr(self, mnemonic.lower())(operand)

    def compare(self, register: int, operand: int) -> None:
        self.c = register >= operand
        self.nz((register - operand) % 256)

    def nop(self, operand: int) -> None:
        pass

    def bit(self, operand: int) -> None:
        self.z = self.a & operand == 0
        self.n, self.v = operand & 128 > 0, operand & 64 > 0

    def ora(self, operand: int) -> None:
        self.a = self.nz(self.a | operand)

    def eor(self, operand: int) -> None:
        self.a = self.nz(self.a ^ operand)

    # `and` is a keyword of Python; `use` finds the method by name.
    def _and(self, operand: int) -> None:
        self.a = self.nz(self.a & operand)

    def anc(self, operand: int) -> None:
        self._and(operand)
        self.c = self.n

    def asr(self, operand: int) -> None:
        self.c = (self.a & operand) % 2 == 1
        self.a = self.nz((self.a & operand) // 2)

    def ane(self, operand: int) -> None:
        self.a = self.nz((self.a | 0xEE) & self.x & operand)

    def lxa(self, operand: int) -> None:
        self.a = self.x = self.nz((self.a | 0xEE) & operand)

    def sbx(self, operand: int) -> None:
        self.c = self.a & self.x >= operand
        self.x = self.nz(((self.a & self.x) - operand) % 256)

    def adc(self, operand: int) -> None:
        old = self.a
        if self.d:
            total = value_of_digits(old) + value_of_digits(operand) + self.c
            self.c = total >= 100
            self.a = digits_of_value(total % 256)
            self.v = sign(old) != sign(self.a) and sign(self.a) != sign(operand)
        else:
            total = old + operand + self.c
            self.v = not -128 <= signed(old) + signed(operand) + self.c <= 127
            self.c = total >= 256
            self.a = total % 256
        self.nz(self.a)

    def sbc(self, operand: int) -> None:
        if not self.d:
            return self.adc(255 - operand)
        old, borrow = self.a, 1 - self.c
        total = value_of_digits(old) - value_of_digits(operand) - borrow
        if total < 0:
            total += 100
        # Still below zero, with digits above 9: ale-py reads before the start of a table.
        self.a = digits_of_value(total) if total >= 0 else value_of_digits(total % 256)
        self.c = old >= operand + borrow
        self.v = sign(old) != sign(self.a) and sign(self.a) != sign(operand)
        self.nz(self.a)

    def arr(self, operand: int) -> None:
        masked = self.a & operand
        result = masked // 2 + 128 * self.c
        if not self.d:
            self.a = self.nz(result)
            self.c = result & 64 > 0
            self.v = (result & 64 > 0) != (result & 32 > 0)
            return
        self.n, self.z = self.c, result == 0
        self.v = (masked & 64) != (result & 64)
        low, high = masked % 16, masked // 16
        if low + masked % 2 > 5:
            result = result // 16 * 16 + (result + 6) % 16
        self.c = high + high % 2 > 5
        if self.c:
            result = (result + 0x60) % 256
        self.a = result

    def control(self, opcode: Opcode) -> None:
        mnemonic = opcode.mnemonic
        if mnemonic in FLAG_CHANGES:
            setattr(self, *FLAG_CHANGES[mnemonic])
        elif mnemonic in TRANSFERS:
            source, target = TRANSFERS[mnemonic]
            setattr(self, target, self.nz(getattr(self, source)))
        elif mnemonic in STEPS:
            register, step = STEPS[mnemonic]
            setattr(self, register, self.nz((getattr(self, register) + step) % 256))
        else:
            getattr(self, f"control_{mnemonic.lower()}")(opcode)

    def control_nop(self, opcode: Opcode) -> None:
        pass

    def control_txs(self, opcode: Opcode) -> None:
        self.sp = self.x

    def control_jam(self, opcode: Opcode) -> None:
        self.jammed = True

    def control_jmp(self, opcode: Opcode) -> None:
        target = self.word()
        if opcode.mode == "ind":
            pointer = target
            target = self.bus.read(pointer)
            same_page = pointer // 256 * 256 + (pointer + 1) % 256
            target |= self.bus.read(same_page) << 8
        self.pc = target

    def control_jsr(self, opcode: Opcode) -> None:
        low = self.fetch()
        self.bus.read(0x100 + self.sp)
        self.push(self.pc // 256)
        self.push(self.pc % 256)
        self.pc = low | self.bus.read(self.pc) << 8

    def control_rts(self, opcode: Opcode) -> None:
        self.bus.read(0x100 + self.sp)
        low = self.pull()
        self.pc = low | self.pull() << 8
        self.fetch()

    def control_rti(self, opcode: Opcode) -> None:
        self.bus.read(0x100 + self.sp)
        self.ps = self.pull()
        low = self.pull()
        self.pc = low | self.pull() << 8

    def control_brk(self, opcode: Opcode) -> None:
        self.fetch()
        self.push(self.pc // 256)
        self.push(self.pc % 256)
        self.push(self.ps)
        self.i = True
        low = self.bus.read(0xFFFE)
        self.pc = low | self.bus.read(0xFFFF) << 8

    def control_pha(self, opcode: Opcode) -> None:
        self.push(self.a)

    def control_php(self, opcode: Opcode) -> None:
        self.push(self.ps)

    def control_pla(self, opcode: Opcode) -> None:
        self.bus.read(0x100 + self.sp)
        self.a = self.nz(self.pull())

    def control_plp(self, opcode: Opcode) -> None:
        self.bus.read(0x100 + self.sp)
        self.ps = self.pull()


setattr(Model6502, "and", Model6502._and)


def signed(byte: int) -> int:
    return byte if byte < 128 else byte - 256


def sign(byte: int) -> bool:
    return byte >= 128


def value_of_digits(byte: int) -> int:
    """The value of two decimal digits, also if a digit is above 9."""
    return byte // 16 * 10 + byte % 16


def digits_of_value(number: int) -> int:
    """The last two decimal digits of a number, as a byte."""
    return int(f"{number % 100:02d}", 16)
