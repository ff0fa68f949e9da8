"""Random programs for the 2600 that stay inside their ROM and use the chips in ways that no game does."""

import random

from emulator.machines import W

START = 0xF000
RETURN = 0xFE00  # an RTS, after all code
SIZE_OF_CODE = 3400

STRAY = {0x00, 0x20, 0x40, 0x60, 0x4C, 0x6C} | {0x10 + 0x20 * k for k in range(8)}
JAMS = {0x02, 0x12, 0x22, 0x32, 0x42, 0x52, 0x62, 0x72, 0x92, 0xB2, 0xD2, 0xF2}


def lengths() -> list[int]:
    """Bytes of every opcode, from the pattern of the low five bits."""
    by_column = [2, 2, 2, 2, 2, 2, 2, 2, 1, 2, 1, 2, 3, 3, 3, 3, 2, 2, 1, 2, 2, 2, 2, 2, 1, 3, 1, 3, 3, 3, 3, 3]
    table = [by_column[opcode & 31] for opcode in range(256)]
    table[0x82] = table[0xA2] = table[0xC2] = table[0xE2] = 2
    return table


LENGTHS = lengths()


class Code:
    """Machine code that grows."""

    def __init__(self) -> None:
        self.bytes = bytearray()

    def emit(self, *code: int) -> None:
        self.bytes += bytes(code)

    def store(self, value: int, register: int) -> None:
        self.emit(0xA9, value, 0x85, register)

    def begin_frame(self) -> None:
        """Three lines of VSYNC."""
        self.store(2, W.VSYNC)
        self.emit(*[0x85, W.WSYNC] * 3)
        self.store(0, W.VSYNC)

    def image(self, again: int) -> bytes:
        """4 KiB: the code, a jump back, the subroutine, the vectors."""
        self.emit(0x4C, *(START + again).to_bytes(2, "little"))
        assert START + len(self.bytes) <= RETURN
        image = bytearray(4096)
        image[: len(self.bytes)] = self.bytes
        image[RETURN - START] = 0x60
        image[-4:] = START.to_bytes(2, "little") * 2
        return bytes(image)


def tia_program(rng: random.Random) -> bytes:
    """Writes of all video and sound registers, at all positions of the line, in frames of all lengths."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)  # SEI CLD LDX #$FF TXS
    again = len(code.bytes)
    code.begin_frame()
    shown = range(W.RSYNC, W.CXCLR + 1)
    for _ in range(rng.randint(30, 700)):
        choice = rng.random()
        if choice < 0.45:
            register, value = rng.choice(shown), rng.randrange(256)
            code.store(value, register)
        elif choice < 0.55:
            code.emit(0x85, W.WSYNC)
        elif choice < 0.62:
            code.emit(0x85, W.HMOVE)
        elif choice < 0.67:
            code.emit(0x85, rng.choice((W.RESP0, W.RESP1, W.RESM0, W.RESM1, W.RESBL)))
        elif choice < 0.75:
            code.emit(0xEA)
        elif choice < 0.81:
            code.emit(0x24, 0x80)  # BIT, three cycles
        elif choice < 0.88:
            code.emit(0xA5, rng.randrange(16), 0x05, 0x90 + rng.randrange(8), 0x85, 0x90 + rng.randrange(100))
        elif choice < 0.92:
            code.emit(0x85, 0x80 + rng.randrange(120))
        elif choice < 0.95:
            code.emit(0xA2, rng.randrange(1, 20), 0xCA, 0xD0, 0xFD)  # a loop of DEX
        elif choice < 0.97:
            code.emit(0xAD, 0x84, 0x02, 0x85, 0x80 + rng.randrange(100))  # INTIM
        elif choice < 0.98:
            code.store(rng.choice((0x00, 0x82)), W.VBLANK)
        else:
            code.store(rng.randrange(256), W.CTRLPF)
        if len(code.bytes) > SIZE_OF_CODE:
            break
    for _ in range(rng.choice((0, 1, 1, 2))):  # empty lines, at times more than a frame may have
        code.emit(0xA2, rng.randrange(1, 256), 0x85, W.WSYNC, 0xCA, 0xD0, 0xFB)
    return code.image(again)


def cpu_program(rng: random.Random) -> bytes:
    """All instructions in random order with random operands, documented or not; jumps lead back to the line."""
    code = Code()
    code.emit(0xD8, 0xA2, 0xFF, 0x9A)
    again = len(code.bytes)
    code.begin_frame()
    size = rng.randint(200, SIZE_OF_CODE)
    while len(code.bytes) < size:
        choice = rng.random()
        opcode = rng.randrange(256)
        if choice < 0.02:
            code.emit(0xA2, rng.randrange(0x84, 0x100), 0x9A, 0x20, *RETURN.to_bytes(2, "little"))  # LDX TXS JSR
        elif choice < 0.04:
            target = START + len(code.bytes) + 5  # JMP ($..): the pointer is after the jump
            pointer = target - 2
            if pointer & 0xFF != 0xFF:
                code.emit(0x6C, *pointer.to_bytes(2, "little"), *target.to_bytes(2, "little"))
        elif choice < 0.12:
            code.emit(rng.randrange(8) * 0x20 + 0x10, 2, 0xE6, rng.randrange(0x80, 0x100))  # a branch over INC
        elif opcode not in STRAY | JAMS:
            code.emit(opcode, *operand(rng)[: LENGTHS[opcode] - 1])
    return code.image(again)


def operand(rng: random.Random) -> bytes:
    """Mostly RAM; also TIA, RIOT, ROM, the ends of pages."""
    choice = rng.random()
    if choice < 0.5:
        address = rng.choice((0x0000, 0x0100, 0x0400)) + rng.randrange(0x80, 0x100)
    elif choice < 0.6:
        address = rng.randrange(0x100)
    elif choice < 0.7:
        address = rng.randrange(0x280, 0x298)
    elif choice < 0.8:
        address = rng.choice((0x00FF, 0x01FF, 0x10FF, 0xFFFF))
    else:
        address = rng.randrange(0x10000)
    return address.to_bytes(2, "little")
