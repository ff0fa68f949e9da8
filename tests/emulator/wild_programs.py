"""Random programs without rules: they run through ROM, RAM, chips and banks, and may hang or stop.

They serve to compare two machines that must do the same for any program. The cases that the fast interpreter or the
deferred TIA could get wrong are frequent here, and rare in games.
"""

import random
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from emulator.machines import R, W
from emulator.programs import JAMS, LENGTHS, START, Code

SIZES = {
    "2K": 2048, "4K": 4096, "F8": 8192, "F8 SWAPPED": 8192, "F6": 16384, "F4": 32768, "F8SC": 8192, "F6SC": 16384,
    "F4SC": 32768, "FASC": 12288, "E0": 8192, "E7": 16384, "FE": 8192, "DPC": 10496, "3F": 8192, "3E": 8192, "UA": 8192,
    "CV": 4096, "MB": 65536,
}  # fmt: skip
"""A usual image size of each cartridge type."""

BRANCHES = [0x10 + 0x20 * k for k in range(8)]
LOADS, STORES = (0xA9, 0xA2, 0xA0), (0x85, 0x86, 0x84)  # A, X, Y: immediate, zero page
TIMERS = (R.TIM1T, R.TIM8T, R.TIM64T, R.T1024T)
IMPLIED = (0x18, 0x38, 0x18, 0x38, 0xE8, 0xCA, 0xAA, 0x98, 0x0A, 0x6A, 0x08, 0x68, 0x48, 0xB8, 0xEA)  # CLC, SEC, ...
IMMEDIATE = (0xA9, 0xA2, 0x69, 0xE9, 0x69, 0xE9, 0x29, 0xC9)  # LDA, LDX, ADC, SBC, AND, CMP
ON_RAM = (0xA5, 0x65, 0xE5, 0xE6, 0x24, 0x95)  # LDA, ADC, SBC, INC, BIT, STA with an index
MIRRORS_OF_INTIM = (0x284, 0x286, 0x294, 0x2AC, 0x384, 0x684, 0xE284)
MIRRORS_OF_TIMINT = (0x285, 0x287, 0x29D, 0x3AF, 0xE685)
COLLISIONS = range(8)
SHOWN = list(range(W.NUSIZ0, W.CXCLR + 1))  # all registers that affect video or sound
OBJECTS = [W.GRP0, W.GRP1, W.ENAM0, W.ENAM1, W.ENABL, W.PF0, W.PF1, W.PF2]
STROBES = [W.RESP0, W.RESP1, W.RESM0, W.RESM1, W.RESBL, W.HMOVE]
COUNTER = 0x80  # in RAM, of frames

Ingredient = Callable[[random.Random], bytes]
"""A function that makes some machine code."""


def noise(rng: random.Random, kind: str) -> bytes:
    """Random bytes; the vector at the end of each KiB is a random address."""
    return with_vectors(bytearray(rng.randbytes(SIZES[kind])), rng)


def soup(rng: random.Random, kind: str) -> bytes:
    """Instructions in random order, and between them sequences that are common in games.

    After 8 KiB, pages of 256 bytes are those of the beginning, in random order: a program runs through few of them.
    """
    code, state = _mixed(rng.getstate(), min(SIZES[kind], 8192))
    rng.setstate(state)
    image = bytearray(code[:8192])
    while len(image) < SIZES[kind]:
        page = 256 * rng.randrange(32)
        image += image[page : page + 256]
    return with_vectors(image[: SIZES[kind]], rng)


@lru_cache(maxsize=64)
def _mixed(state: tuple[Any, ...], size: int) -> tuple[bytes, tuple[Any, ...]]:
    """Instructions from a generator in this state, and its next one: images of all types begin with the same ones."""
    rng, image = random.Random(), bytearray()
    rng.setstate(state)
    while len(image) < size:
        image += rng.choices(INGREDIENTS, AMOUNTS)[0](rng)
    return bytes(image), rng.getstate()


def with_vectors(image: bytearray, rng: random.Random) -> bytes:
    for end in range(1024, len(image) + 1, 1024):
        image[end - 4 : end] = b"".join(rng.randrange(0xF000, 0xFF00).to_bytes(2, "little") for _ in range(2))
    return bytes(image)


def word(address: int) -> bytes:
    return (address & 0xFFFF).to_bytes(2, "little")


def address(rng: random.Random) -> int:
    """An address, mostly one with a chip, RAM or ROM."""
    choice = rng.random()
    if choice < 0.3:
        return rng.choice((0x00, 0x100, 0x400)) + rng.randrange(0x80, 0x100)
    if choice < 0.45:
        return rng.choice((0x00, 0x40, 0x100, 0x3C0, 0x2000)) + rng.randrange(0x40)
    if choice < 0.55:
        return rng.choice((0x280, 0x290, 0x380)) + rng.randrange(16)
    if choice < 0.65:  # hotspots
        return rng.choice((0xFFE0, 0xFFF0, 0x1FF0, 0xBFF0, 0x1FE0, 0x01F8, 0x003A, 0x0220, 0x0240)) + rng.randrange(16)
    if choice < 0.8:  # RAM and registers in the window
        return rng.choice((0xF000, 0x1000)) + rng.randrange(0xC00)
    if choice < 0.85:  # ends of pages and of the address space
        return rng.choice((0xFF, 0x17F, 0x1FF, 0xFFF, 0x10FF, 0x1FFF, 0xF7FF, 0xFFFF))
    return rng.randrange(0x10000)


def any_instruction(rng: random.Random) -> bytes:
    """Any opcode, documented or not; rarely one that stops the processor."""
    opcode = rng.randrange(256)
    if (opcode in JAMS or opcode == 0) and rng.random() < 0.97:
        opcode = 0xEA
    if opcode in (0x20, 0x4C):
        return bytes([opcode]) + word(rng.randrange(0xF000, 0x10000))
    return bytes([opcode]) + word(address(rng))[: LENGTHS[opcode] - 1]


def load(rng: random.Random) -> bytes:
    return bytes([rng.choice(LOADS), rng.choice((0, 0xFF, rng.randrange(256)))])


def store_in_ram(rng: random.Random) -> bytes:
    return bytes([rng.choice(STORES), rng.randrange(0x80, 0x100)])


def store_in_tia(rng: random.Random) -> bytes:
    return bytes([rng.choice(LOADS), rng.randrange(256), rng.choice(STORES), rng.choice(SHOWN)])


def branch(rng: random.Random) -> bytes:
    distance = rng.choice((rng.randrange(-20, 21), rng.randrange(1, 8), rng.randrange(-128, 128)))
    return bytes([rng.choice(BRANCHES), distance & 0xFF])


def jump(rng: random.Random) -> bytes:
    """A jump into the window, often to an address whose preceding instruction switches banks."""
    target = rng.choice((0x1000, 0xF000, 0xD000)) + rng.choice((rng.randrange(0xFF0), rng.randrange(0xFD0, 0xFF0)))
    return bytes([rng.choice((0x4C, 0x20, 0x20))]) + word(target)


def return_or_stack(rng: random.Random) -> bytes:
    return bytes([rng.choice((0x60, 0x48, 0x68, 0x08, 0x28, 0x9A, 0xBA, 0x40, 0x48, 0x68))])


def stack_pointer(rng: random.Random) -> bytes:
    """A stack pointer, mostly in RAM; also where pushes reach the TIA's registers of missiles and ball, as in games."""
    place = rng.choice((0xFF, 0xFF, 0x1F, 0x81, 0x7F, 0x00, rng.randrange(256)))
    return bytes([0xA2, place, 0x9A])


def wait_for_line(_: random.Random) -> bytes:
    return bytes([0x85, W.WSYNC])


def vertical_sync(rng: random.Random) -> bytes:
    wait = bytes([0x85, W.WSYNC]) * rng.choice((0, 1, 3, 3))
    return bytes([0xA9, 2, 0x85, W.VSYNC]) + wait + bytes([0xA9, 0, 0x85, W.VSYNC])


def collisions(rng: random.Random) -> bytes:
    """Collisions, cleared or read by an instruction of any kind."""
    if rng.random() < 0.4:
        return bytes([0x85, W.CXCLR])
    opcode = rng.choice((0xA5, 0x24, 0x05, 0xB5, 0xA6, 0xC5))
    return bytes([opcode, rng.choice((0x00, 0x30)) + rng.choice(COLLISIONS), 0x85, rng.randrange(0x80, 0x100)])


def timer(rng: random.Random) -> bytes:
    """A timer, set or waited for."""
    if rng.random() < 0.5:
        return bytes([0xA9, rng.choice((0, 1, 2, rng.randrange(256))), 0x8D]) + word(rng.choice(TIMERS))
    return poll(rng)


def poll(rng: random.Random) -> bytes:
    """A loop that reads the timer or its expiry, and often waits for it."""
    opcode = rng.choice((0xAD, 0xAD, 0xAD, 0xAE, 0xAC, 0x2C, 0xCD, 0x0D))
    distance = rng.choice((-5, -5, -5, -5, -4, -6))
    wait = rng.choice((0xD0, 0xD0, 0x10, 0x10, 0x30, 0xF0, 0x90, 0x50))
    mirrors = rng.choice((MIRRORS_OF_INTIM, MIRRORS_OF_INTIM, MIRRORS_OF_TIMINT))
    return bytes([opcode]) + word(rng.choice(mirrors)) + bytes([wait, distance & 0xFF])


def count_down(rng: random.Random) -> bytes:
    """A loop of DEX or DEY, perhaps with a WSYNC: mostly to zero or past it, from anywhere."""
    way = rng.choice(((0xA2, 0xCA), (0xA0, 0x88)))
    line = rng.choice((b"", b"", b"", bytes([rng.choice(STORES), W.WSYNC])))
    many = rng.randrange(20) if line else rng.choice((0x7F, 0x80, 0x81, rng.randrange(256)))
    count = rng.choice((rng.randrange(40), many))
    branch = rng.choice((0xD0, 0xD0, 0x10, 0x10, rng.choice(BRANCHES)))
    distance = rng.choice((-3 - len(line), -3 - len(line), -3 - len(line), -3, -2))
    return bytes([way[0], count, *line, way[1], branch, distance & 0xFF])


def divide(rng: random.Random) -> bytes:
    """A loop of SBC, with and without carry, in decimal mode, and by zero."""
    by = rng.choice((15, 15, rng.randrange(1, 256), rng.randrange(40)))
    mode = bytes([rng.choice((0x38, 0x38, 0x38, 0x18)), rng.choice((0xD8, 0xD8, 0xD8, 0xF8))])
    return bytes([0xA9, rng.randrange(256), *mode, 0xE9, by, rng.choice((0xB0, 0xB0, 0xB0, 0x90)), 0xFC])


def code_in_ram(rng: random.Random) -> bytes:
    """Writes an instruction into RAM and jumps to it, or to the current content."""
    place = rng.randrange(0x80, 0xF0)
    written = bytes(part for k, byte in enumerate(any_instruction(rng)) for part in (0xA9, byte, 0x85, place + k))
    back = bytes([0xA9, 0x60, 0x85, place + 3])
    return rng.choice((written, b"")) + rng.choice((back, b"")) + bytes([0x20, *word(place)])


def pointer(rng: random.Random) -> bytes:
    """A pointer in RAM, and an access or a jump through it."""
    place, target = rng.randrange(0x80, 0xFF), word(address(rng))
    made = bytes([0xA9, target[0], 0x85, place, 0xA9, target[1], 0x85, place + 1])
    through = bytes([rng.choice((0xB1, 0x91, 0x11, 0xD1, 0x71, 0xF1)), rng.choice((place, place, 0x7F, 0xFF, 0x80))])
    indexed = bytes([0xA2, 0, rng.choice((0xA1, 0x81, 0xC1)), place])
    return made + rng.choice((through, through, indexed, bytes([0x6C]) + word(place)))


def input_port(rng: random.Random) -> bytes:
    return bytes([rng.choice((0xA5, 0x24)), rng.randrange(8, 14), 0x85, rng.randrange(0x80, 0x100)])


def nothing(rng: random.Random) -> bytes:
    return bytes([0xEA]) * rng.randrange(1, 4)


INGREDIENTS, AMOUNTS = zip(
    *{
        any_instruction: 25, load: 6, store_in_ram: 8, store_in_tia: 14, branch: 10, jump: 5, return_or_stack: 4,
        stack_pointer: 1, wait_for_line: 6, vertical_sync: 1, collisions: 5, timer: 3, count_down: 1, divide: 1, code_in_ram: 1,
        pointer: 3, input_port: 1, nothing: 2,
    }.items(), strict=True,
)  # fmt: skip


def changing_frames(rng: random.Random) -> bytes:
    """Frames drawn from values in RAM, which each frame changes, with parts that only some frames run.

    Lines, collisions, clearing and vertical sync may each be missing, of every frame or of some.
    """
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    again = len(code.bytes)
    code.emit(0xE6, COUNTER)
    if rng.random() < 0.9:
        sometimes(code, rng, vertical_sync)
    favourites = rng.choice((OBJECTS, STROBES, SHOWN, rng.sample(SHOWN, 5)))
    for _ in range(rng.choice((3, 40, 250))):
        part = rng.random()
        register = rng.choice(SHOWN if part < 0.3 else favourites)
        if part < 0.55:
            code.emit(
                *rng.choice(((0xA5, rng.randrange(0x80, 0x100)), (0xA9, rng.choice((0, 0xFF, rng.randrange(256))))))
            )
            code.emit(0x85, register)
        elif part < 0.65:
            code.emit(0x85, rng.choice(STROBES))
        elif part < 0.73:
            code.emit(0xA2, rng.choice((1, 1, 2, 5, 60)), 0x85, W.WSYNC, 0xCA, 0xD0, 0xFB)
        elif part < 0.78:
            code.emit(*[0xEA] * rng.randrange(1, 5))
        elif part < 0.82:
            code.emit(0x24, 0x80)
        elif part < 0.86:
            code.emit(0xE6, rng.randrange(0x81, 0xC0), 0x46, rng.randrange(0x81, 0xC0))
        elif part < 0.92:
            sometimes(code, rng, collisions)
        elif part < 0.96:
            sometimes(code, rng, lambda _: bytes([0x85, W.CXCLR]))
        elif part < 0.98:
            cosmic_ark(code, rng)
        else:
            code.store(rng.choice((0x00, 0x00, 0x02, 0x42, 0x82)), W.VBLANK)
        if len(code.bytes) > 3000:
            break
    if rng.random() < 0.7:
        code.emit(0xA2, rng.randrange(1, 256), 0x85, W.WSYNC, 0xCA, 0xD0, 0xFB)
    if rng.random() < 0.15:
        sometimes(
            code, rng, lambda _: bytes([0xA0, 0, 0xA2, 0, 0xCA, 0xD0, 0xFD, 0x88, 0xD0, 0xF8])
        )  # 131072 instructions
    if rng.random() < 0.05:
        sometimes(code, rng, lambda _: bytes([0x02]))
    return code.image(again)


def nearly_still(rng: random.Random) -> bytes:
    """Frames that depend only on some bytes of RAM, so that only a poke changes them. Most lines have no TIA writes."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    again = len(code.bytes)
    code.begin_frame()
    favourites = rng.choice((SHOWN, SHOWN, [W.ENABL, W.VDELBL, W.GRP1, W.RESBL], [*OBJECTS, *STROBES]))
    lines = 0
    for block in range(rng.randrange(3, 9)):
        for _ in range(rng.randrange(3, 20) if block == 0 else rng.randrange(4)):
            code.emit(*[0xEA] * rng.randrange(4), 0xA5, rng.randrange(0x80, 0x100), 0x85, rng.choice(favourites))
            if rng.random() < 0.3:
                code.emit(0x85, W.WSYNC)
        wait = rng.choice((1, 2, 3, 20, 60))
        code.emit(0xA2, wait, 0x85, W.WSYNC, 0xCA, 0xD0, 0xFB)
        lines += wait
    code.emit(0xA2, max(1, 250 - lines), 0x85, W.WSYNC, 0xCA, 0xD0, 0xFB)
    return code.image(again)


def glances(rng: random.Random) -> bytes:
    """Frames that change little, with strobes in most lines. Only some frames read and clear collisions."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    again = len(code.bytes)
    code.begin_frame()
    code.emit(0xE6, COUNTER)
    latches = rng.sample(COLLISIONS, 2)
    lines = 0
    while lines < 220:
        for _ in range(rng.randrange(5)):
            code.emit(
                *[0xEA] * rng.randrange(4), 0xA5, rng.randrange(0x81, 0xC0), 0x85, rng.choice((*OBJECTS, *STROBES))
            )
        if rng.random() < 0.7:
            sometimes(code, rng, lambda rng: bytes([0xA5, rng.choice(latches), 0x85, rng.randrange(0xC0, 0xF0)]))
        if rng.random() < 0.3:
            sometimes(code, rng, lambda rng: bytes([0x85, W.CXCLR]))
        wait = rng.choice((1, 10, 30, 60))
        strobes = [part for _ in range(rng.randrange(2, 7)) for part in (0x85, rng.choice(STROBES))]
        code.emit(0xA2, wait, 0x85, W.WSYNC, *strobes, 0xCA, 0xD0, -5 - len(strobes) & 0xFF)
        lines += wait
    return code.image(again)


def sometimes(code: Code, rng: random.Random, part: Ingredient) -> None:
    """Emit a part that runs in every frame, or if some bits of the frame's number are set, or if they are clear."""
    made = part(rng)
    if rng.random() < 0.7:
        code.emit(0xA5, COUNTER, 0x29, rng.choice((1, 3, 4, 8, 0x30)), rng.choice((0xD0, 0xF0)), len(made))
    code.emit(*made)


def cosmic_ark(code: Code, rng: random.Random) -> None:
    """A write of HMM0 21 cycles after HMOVE, which sets missile 0 in motion; other writes may follow shortly after."""
    code.store(0x70, W.HMM0)
    code.emit(0xA9, 0x60, 0x85, W.WSYNC, 0x85, W.HMOVE)
    code.emit(*[0xEA] * 9, 0x85, W.HMM0)
    if rng.random() < 0.5:
        code.emit(0x85, rng.choice((W.RESM0, W.NUSIZ0, W.RESMP0, W.ENAM0)))


def starfield(rng: random.Random) -> bytes:
    """Missile 0 in motion over the whole frame, among small objects that stand still; collisions are read in each line.

    Some frames write the registers that stop the motion late, sometimes with the value they already have.
    """
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    size = rng.choice((0x00, 0x00, 0x10, 0x20, 0x03, 0x34))
    code.store(size, W.NUSIZ0)
    code.store(rng.choice((0x00, 0x20, 0x06)), W.NUSIZ1)
    code.store(2, W.ENAM0)
    for register in rng.sample([W.ENABL, W.ENAM1, W.GRP0, W.GRP1], 2):
        code.store(rng.choice((2, 3, 0x81)), register)
    code.store(rng.randrange(256), W.COLUP0)
    for strobe in rng.sample([W.RESBL, W.RESM1, W.RESP0, W.RESP1], 4):
        code.emit(*[0xEA] * rng.randrange(6), 0x85, strobe)
    again = len(code.bytes)
    code.emit(0xE6, COUNTER)
    code.begin_frame()
    code.store(0x70, W.HMM0)
    code.emit(0xA9, 0x60, 0x85, W.WSYNC, 0x85, W.HMOVE)
    writes = (*[0xEA] * 9, 0x85, W.HMM0), (*[0xEA] * 8, 0x99, W.HMM0, 0), (*[0xEA] * 7, 0x24, 0x80, 0x8D, W.HMM0, 0)
    code.emit(*rng.choice(writes))
    for _ in range(rng.choice((1, 2, 3))):
        code.emit(0xA2, rng.randrange(20, 100))
        line = len(code.bytes)
        code.emit(0x85, W.WSYNC)
        for flags in rng.sample(COLLISIONS, rng.choice((1, 2))):
            code.emit(0xA5, flags, 0x65, 0x90 + flags, 0x85, 0x90 + flags)
        code.emit(0x85, W.CXCLR, *[0xEA] * rng.choice((0, 0, 3, 8)), 0xCA, 0xD0)
        code.emit((line - len(code.bytes) - 1) & 0xFF)
        stop = rng.choice((W.NUSIZ0, W.NUSIZ0, W.RESM0, W.HMOVE, W.RESMP0))
        sometimes(code, rng, lambda _, stop=stop: bytes([0xA9, rng.choice((size, size, 0x20)), 0x85, stop]))
    return code.image(again)


def short_frames(rng: random.Random) -> bytes:
    """Frames of a few lines, of varying length, that end anywhere in a line, often shortly after an HMOVE."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    code.store(0x3A, W.COLUBK)
    code.store(rng.randrange(256), W.PF1)
    again = len(code.bytes)
    code.emit(0xE6, COUNTER)
    for register in rng.sample([W.COLUBK, W.PF2, W.GRP0, W.HMP0], 2):
        sometimes(code, rng, lambda _, register=register: bytes([0xA5, COUNTER, 0x85, register]))
    code.store(2, W.VSYNC)
    code.emit(0xA5, COUNTER, 0x29, rng.choice((1, 4, 8)), 0xA8)  # in Y 0 or not
    code.emit(0xA5, COUNTER, 0x29, rng.choice((1, 2, 3, 7)), 0x09, rng.choice((1, 1, 8, 0x28)), 0xAA)
    code.emit(0x85, W.WSYNC, 0xCA, 0xD0, 0xFB, 0xA9, 0)
    delay = rng.choice((0, 0, rng.randrange(70), 64, 66, 66, 67))  # cycles; with 66, HMOVE ends in cycle 75
    code.emit(*[0xEA] * (delay // 2 - delay % 2), *[0x24, 0x80] * (delay % 2))
    code.emit(*rng.choice(((), (0x85, W.HMOVE), (0x99, W.HMOVE, 0))))  # the last where Y is 0
    code.emit(*[0xEA] * rng.choice((0, 0, 1, 5, 9, 20)), 0x85, W.VSYNC)
    return code.image(again)


BLANKED_LOOKS = [
    bytes.fromhex(code) for code in ("", "2400", "2407", "2408", "852C", "853F", "8504", "850D", "8515", "EAEA2402")
]


def blank_ends(look: bytes, wait: int = 0) -> bytes:
    """Frames of 60 and of 40 lines, two of each, that end in the visible line of an HMOVE, after the code `look`."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    code.store(0x3A, W.COLUBK)
    again = len(code.bytes)
    code.emit(0xE6, COUNTER, 0xA2, 60, 0xA5, COUNTER, 0x29, 2, 0xF0, 2, 0xA2, 40)  # LDX #60 or #40
    code.store(2, W.VSYNC)
    code.emit(0x85, W.WSYNC, 0xCA, 0xD0, 0xFB, 0xA9, 0, 0x85, W.HMOVE, *look, *[0xEA] * wait, 0x85, W.VSYNC)
    return code.image(again)


STORES_BEFORE_TIA_SPACE = [
    *(bytes([0xEA, 0x85, register]) for register in (W.VBLANK, W.NUSIZ0, W.COLUBK, W.REFP1, W.PF0, W.PF2, W.RESM1)),
    *(bytes([0x85, register, last]) for register in (W.NUSIZ0, W.NUSIZ1, W.PF1) for last in (0xEA, 0xC0)),  # NOP, CPY
    bytes([0x95, W.NUSIZ0, 0xEA]),
]


def runs_into_tia_space(end: bytes, kind: str = "4K") -> bytes:
    """Runs in every frame three bytes whose store writes a 0 to the TIA, where a 0 is; the address after them is in TIA
    space. They are at the end of RAM, or of the window on a cartridge of type FE.

    Missile 0 and both players, which overlap it, move by a pixel a frame. The store ends close to the missile's pixel,
    and may show after it; latches are then read as an opcode or an operand. BRK leaves TIA space.
    """
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xF0, 0x9A)
    for address, value in ((0x80, 0), *enumerate(end, 0xFD), (W.GRP0, 0xFF), (W.GRP1, 0xFF), (W.ENAM0, 2)):
        code.store(value, address)
    code.emit(0x85, W.WSYNC, *[0xEA] * 17, 0x85, W.RESP0, 0x85, W.RESP1)
    code.store(2, W.RESMP0)
    code.store(0x70, W.HMP1)
    code.emit(0x85, W.WSYNC, 0x85, W.HMOVE, 0xA9, 0x10, 0x85, W.HMP0, 0x85, W.HMP1, 0x85, W.HMM0)
    code.store(0, W.RESMP0)
    again = len(code.bytes)
    code.begin_frame()
    code.emit(0x85, W.WSYNC, 0x85, W.HMOVE, 0xA2, 60, 0x85, W.WSYNC, 0xCA, 0xD0, 0xFB)
    code.emit(0x85, W.CXCLR, *[0xEA] * 9, 0xA9, 0, 0x38, 0x4C, *word(0xDFFD if kind == "FE" else 0xFD))
    handler = START + len(code.bytes)
    code.emit(0x85, 0x91, 0x68, 0x85, 0x92, 0x68, 0x85, 0x93, 0x68, 0xE6, COUNTER + 1)
    image = code.image(again)[:-2] + word(handler)
    return image + bytes(4093) + end if kind == "FE" else image


def glances_at_blanks(rng: random.Random) -> bytes:
    """As `short_frames`; between HMOVE and the frame's end latches are read and cleared, also by accesses that only pass
    over their addresses."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    code.store(0x3A, W.COLUBK)
    code.store(rng.randrange(256), W.PF1)
    again = len(code.bytes)
    code.emit(0xE6, COUNTER)
    for register in rng.sample([W.COLUBK, W.PF2, W.GRP0, W.HMP0], 2):
        sometimes(code, rng, lambda _, register=register: bytes([0xA5, COUNTER, 0x85, register]))
    code.store(2, W.VSYNC)
    code.emit(0xA5, COUNTER, 0x29, rng.choice((1, 2, 4, 8)), 0xA8)  # in Y 0 or not
    lines = rng.choice((1, 1, 8, 19, 20, 33, 34, 0x28))
    code.emit(0xA5, COUNTER, 0x29, rng.choice((0, 0, 1, 2, 3, 7)), 0x09, lines, 0xAA)
    code.emit(0x85, W.WSYNC, 0xCA, 0xD0, 0xFB, 0xA9, 0)
    delay = rng.choice((0, 0, rng.randrange(70), 64, 66, 66, 67))
    code.emit(*[0xEA] * (delay // 2 - delay % 2), *[0x24, 0x80] * (delay % 2))
    code.emit(*rng.choice(((), (0x85, W.HMOVE), (0x99, W.HMOVE, 0))))
    for _ in range(rng.randrange(5)):
        any_byte, latch = rng.randrange(256), rng.randrange(8)
        writes = (0x85, rng.choice((W.NUSIZ0, W.PF0, W.RESP0, W.HMOVE, W.CXCLR, W.CXCLR))), (0x99, W.CXCLR, 0)
        reads = (0x24, latch), (0x04, latch), (0xA7, latch), (0xE6, latch | 3), (0x14, any_byte), (0xB1, any_byte)
        indexed = (0xA2, any_byte), (0xBD, 0xFF, 0x00), (0xBD, any_byte, 0), (0x1C, any_byte, 0), (0xFE, 0xFF, 0x00)
        code.emit(*rng.choice((*writes, *reads, *indexed)))
    sometimes(code, rng, lambda _: bytes([0x24, rng.randrange(8)]))
    code.emit(*[0xEA] * rng.choice((0, 0, 1, 5, 9, rng.randrange(30))), 0xA9, 0, 0x85, W.VSYNC)
    return code.image(again)


def waiting(rng: random.Random) -> bytes:
    """Loops, and waits for the timer: every form, interval and place in a page, also after expiry."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    again = len(code.bytes)
    while len(code.bytes) < 2500:
        part = rng.random()
        if part < 0.25:
            interval, most = rng.choice(
                ((R.TIM1T, 256), (R.TIM8T, 256), (R.TIM64T, 256), (R.TIM64T, 40), (R.T1024T, 20), (R.T1024T, 256))
            )
            code.emit(0xA9, rng.choice((0, 1, 0x80, 0xFF, rng.randrange(most))) % most, 0x8D, *word(interval))
        elif part < 0.55:
            code.emit(*poll(rng))
            code.emit(0x08, 0x68, rng.choice(STORES), rng.randrange(0x81, 0xF0))
        elif part < 0.65:
            code.emit(*count_down(rng))
            code.emit(0x08, 0x68, rng.choice(STORES), rng.randrange(0x81, 0xF0))
        elif part < 0.7:
            code.emit(*divide(rng))
            code.emit(0x08, 0x68, rng.choice(STORES), rng.randrange(0x81, 0xF0))
        elif part < 0.8:
            code.emit(*nothing(rng))
        elif part < 0.88:
            code.emit(*vertical_sync(rng))
        elif part < 0.9:  # longer than a frame may take
            code.emit(0xA9, rng.randrange(256), 0x8D, *word(R.T1024T), 0xAD, *word(R.INTIM), 0xD0, 0xFB)
            code.emit(*vertical_sync(rng))
        else:
            code.emit(*store_in_tia(rng))
    return code.image(again)


def entered_anywhere(rng: random.Random) -> bytes:
    """Long blocks of carries, sums, flags and stores, which pointers enter at any instruction. There is no VSYNC: a frame
    ends with the first TIA write after the line limit."""
    code = Code()
    code.emit(0x78, 0xD8, 0xA2, 0xFF, 0x9A)
    again = len(code.bytes)
    code.emit(0xE6, COUNTER)
    for _ in range(12):
        line = [straight(rng) for _ in range(rng.randrange(6, 20))]
        places = [sum(map(len, line[:i])) + START + len(code.bytes) + 24 for i in range(len(line))]
        first, second = rng.choices(places, k=2)
        code.emit(0xA2, first & 0xFF, 0xA0, first >> 8, 0xA5, COUNTER, 0x29, rng.choice((1, 2, 4, 7)), 0xF0, 4)
        code.emit(0xA2, second & 0xFF, 0xA0, second >> 8, 0x86, 0xB0, 0x84, 0xB1)
        code.emit(0xA9, rng.randrange(256), rng.choice((0x18, 0x38)), 0x6C, 0xB0, 0)
        for instruction in line:
            code.emit(*instruction)
    return code.image(again)


def straight(rng: random.Random) -> bytes:
    """An instruction that does not jump: it sets, reads or keeps flags."""
    opcode, ram = rng.choice(IMPLIED + IMMEDIATE + ON_RAM + STORES), rng.randrange(0x90, 0xA0)
    if opcode in IMPLIED:
        return bytes([opcode])
    if opcode in IMMEDIATE:
        return bytes([opcode, rng.randrange(256)])
    registers = (W.WSYNC, W.COLUBK, W.PF1, W.GRP0, W.GRP1, W.NUSIZ0, W.HMM0, W.AUDV0)
    return bytes([opcode, rng.choice((ram, *registers)) if opcode in STORES else ram])
