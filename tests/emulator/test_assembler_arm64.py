"""The JIT translator's assembler of arm64, on any processor.

Each row of SEQUENCES has instructions in the processor's own language, and the words that GNU's assembler makes of them.
inspection/arm64_instructions.hpp has the calls of ours, by the same names.
"""

import struct

import atari_inspection
import pytest

# fmt: off
SEQUENCES = {
    "move": (
        "mov w3, w8",
        "2a0803e3",
    ),
    "move_64": (
        "mov x3, x8",
        "aa0803e3",
    ),
    "move_constants": (
        "mov w3, #0; mov w3, #0x1234; movz w3, #0x12, lsl #16; movz w3, #0x5678; movk w3, #0x1234, lsl #16; "
        "movn w3, #0xf; movn w3, #0xed00, lsl #16",
        "52800003 52824683 52a00243 528acf03 72a24683 128001e3 12bda003",
    ),
    "move_constant_64": (
        "movz x3, #0xe124; movk x3, #0x12, lsl #16; movk x3, #0x5500, lsl #32",
        "d29c2483 f2a00243 f2caa003",
    ),
    "loads": (
        "ldrb w3, [x20, #5]; ldr w3, [x20, #3732]; ldr x3, [x20, #3816]; add x16, x20, x9; ldurh w3, [x16, #-127]; "
        "ldurb w3, [x20, #-128]; add x16, x20, #24, lsl #12; add x16, x16, #1696; ldrb w3, [x16]; ldrb w3, [x20, x9]; "
        "add x16, x20, x9, lsl #3; ldr x3, [x16, #3904]; ldr w3, [x20, x9, lsl #2]",
        "39401683 b94e9683 f9477683 8b090290 78581203 38580283 91406290 911a8210 39400203 38696a83 8b090e90 f947a203 "
        "b8697a83",
    ),
    "stores": (
        "strb w3, [x20, #5]; strb wzr, [x20, #5]; mov w17, #7; strb w17, [x20, #5]; add x16, x20, x9; "
        "sturh w3, [x16, #-127]; str w3, [x20, #3732]; str x3, [x20, #3816]",
        "39001683 3900169f 528000f1 39001691 8b090290 78181203 b90e9683 f9077683",
    ),
    "two": (
        "ldp w3, w8, [x20, #12]; stp w3, w8, [x20, #20]",
        "2941a283 2902a283",
    ),
    "addresses": (
        "add w3, w8, #76; sub w3, w8, #1; add w3, w8, #1, lsl #12; add w3, w3, #0x234; add w3, w8, w9, lsl #1; "
        "add w3, w3, #2; add x3, x20, #32; adr x3, .-44",
        "11013103 51000503 11400503 1108d063 0b090503 11000863 91008283 10fffea3",
    ),
    "arithmetic": (
        "add w3, w3, w8; sub w3, w3, #1; and w3, w3, #-128; mov w17, #0x1280; orr w3, w3, w17; ldr w16, [x20, #3732]; "
        "eor w3, w3, w16; ldr x16, [x20, #3816]; sub x3, x3, x16; ldrb w16, [x20, #5]; and w16, w16, #0xfffffff7; "
        "strb w16, [x20, #5]; mov w16, #76; mul w3, w8, w16",
        "0b080063 51000463 12196063 52825011 2a110063 b94e9690 4a100063 f9477690 cb100063 39401690 121c7a10 39001690 "
        "52800990 1b107d03",
    ),
    "after_a_move": (
        "and w3, w8, #15; lsr w3, w8, #7; add w3, w3, #1; add w3, w8, w8; mov w3, w8; sub w3, w3, #1",
        "12000d03 53077d03 11000463 0b080103 2a0803e3 51000463",
    ),
    "bytes": (
        "add w3, w3, #1; uxtb w3, w3; sub w3, w3, #1; uxtb w3, w3; uxtb w3, w8; ubfx w3, w8, #10, #4; lsl w3, w3, #6; "
        "lsl x3, x3, #4; lsr x3, x3, #2; ldrb w16, [x20, #5]; lsr w3, w3, w16",
        "11000463 53001c63 51000463 53001c63 53001d03 530a3503 531a6463 d37cec63 d342fc63 39401690 1ad02463",
    ),
    "comparisons": (
        "cmp w3, w8; cset w3, hi; cmp w3, #127; cinc w8, w8, hs; mov w16, #-1; cmp w3, w16; movz w16, #0x10; "
        "movk w16, #1, lsl #16; cmp x3, x16; ldrb w16, [x20, #5]; cmp w16, w3, uxtb; ldrb w16, [x20, #5]; cmp w16, #0x81; "
        "subs w3, w3, w8; ldrb w16, [x20, #5]; cmp w16, #0; cset w3, ne; tst w8, #255; cset w16, eq; "
        "add w3, w16, w3, lsl #1; ldr x16, [x20, #3744]; cmp x8, x16; cset w3, hs; lsl w3, w3, #7",
        "6b08007f 1a9f97e3 7101fc7f 1a883508 12800010 6b10007f 52800210 72a00030 eb10007f 39401690 6b23021f 39401690 "
        "7102061f 6b080063 39401690 7100021f 1a9f07e3 72001d1f 1a9f17f0 0b030603 f9475290 eb10011f 1a9f37e3 53196063",
    ),
    "jumps": (
        "cbz w3, 1f; cbnz x3, 1f; tst w3, #255; b.eq 1f; tst w3, #128; b.ne 1f; tbz w3, #7, 1f; tst w3, #0x180; "
        "b.ne 1f; lsr x16, x3, x8; tst w16, #1; b.eq 1f; 1: cmp w3, w8; b.ls 1b; b 1b; bl 1b; br x3; blr x3; ret",
        "34000183 b5000163 72001c7f 54000120 7219007f 540000e1 363800c3 7219047f 54000081 9ac82470 7200021f 54000020 "
        "6b08007f 54ffffe9 17fffffe 97fffffd d61f0060 d63f0060 d65f03c0",
    ),
    "add_with_carry": (
        "ldrb w16, [x20, #5]; mvn w16, w16; mvn w16, w16, lsl #24; lsl w17, w3, #24; cmp w8, #1; adcs w17, w17, w16; "
        "cset w8, hs; cset w16, vs; strb w16, [x20, #9]; lsr w3, w17, #24",
        "39401690 2a3003f0 2a3063f0 53081c71 7100051f 3a100231 1a9f37e8 1a9f77f0 39002690 53187e23",
    ),
    "add_constant_with_carry": (
        "movn w16, #0xed00, lsl #16; lsl w17, w3, #24; cmp w8, #1; adcs w17, w17, w16; cset w8, hs; cset w16, vs; "
        "strb w16, [x20, #9]; lsr w3, w17, #24",
        "12bda010 53081c71 7100051f 3a100231 1a9f37e8 1a9f77f0 39002690 53187e23",
    ),
    "add": (
        "lsl w17, w3, #24; adds w17, w17, w9, lsl #24; cset w8, hs; cset w16, vs; strb w16, [x20, #9]; "
        "lsr w3, w17, #24",
        "53081c71 2b096231 1a9f37e8 1a9f77f0 39002690 53187e23",
    ),
    "subtract_with_carry": (
        "ldrb w16, [x20, #5]; lsl w16, w16, #24; lsl w17, w3, #24; cmp w8, #1; sbcs w17, w17, w16; cset w8, hs; "
        "cset w16, vs; strb w16, [x20, #9]; lsr w3, w17, #24",
        "39401690 53081e10 53081c71 7100051f 7a100231 1a9f37e8 1a9f77f0 39002690 53187e23",
    ),
    "subtract": (
        "lsl w17, w3, #24; subs w17, w17, w9, lsl #24; cset w8, hs; cset w16, vs; strb w16, [x20, #9]; "
        "lsr w3, w17, #24",
        "53081c71 6b096231 1a9f37e8 1a9f77f0 39002690 53187e23",
    ),
    "subtract8": (
        "subs w3, w9, #9; cset w8, hs; uxtb w3, w3",
        "71002523 1a9f37e8 53001c63",
    ),
    "log": (
        "mov w16, #0x1b; orr w16, w16, w8, lsl #8; stp w3, w16, [x20], #8; uxtb w16, w8; add w16, w16, w9; "
        "add w3, w3, w16, lsr #8",
        "52800370 2a082210 28814283 53001d10 0b090210 0b502063",
    ),
    "stack": (
        "sub sp, sp, #64; stp x20, x9, [sp, #16]; ldp x20, x9, [sp, #48]; add sp, sp, #64",
        "d10103ff a90127f4 a94327f4 910103ff",
    ),
}
# fmt: on

MEBIBYTE = 2**20


@pytest.mark.parametrize("name", SEQUENCES)
def test_instructions(name: str) -> None:
    instructions, words = SEQUENCES[name]
    code = atari_inspection.arm64_instructions()[name]
    assert [f"{word:08x}" for (word,) in struct.iter_unpack("<I", code)] == words.split(), instructions


def test_every_sequence_has_a_row() -> None:
    assert atari_inspection.arm64_instructions().keys() == SEQUENCES.keys()


def decoded(field: int) -> int:
    """The constant of a logical instruction, as the architecture's manual decodes it (DecodeBitMasks), of 32 bits."""
    rotation, ones = field >> 6, field & 0x3F
    size = next(size for size in (32, 16, 8, 4, 2) if not ones & size)
    run = (1 << (ones & (size - 1)) + 1) - 1
    rotation %= size
    element = (run >> rotation | run << size - rotation) & (1 << size) - 1
    return sum(element << place for place in range(0, 32, size))


def test_logical_constants() -> None:
    """All that the processor has, and numbers near them that it has not."""
    kinds = [(size, ones) for size in (2, 4, 8, 16, 32) for ones in range(1, size)]
    fields = [
        rotation << 6 | (0 if size == 32 else ~(2 * size - 1) & 0x3F) | ones - 1
        for size, ones in kinds
        for rotation in range(size)
    ]
    constants = {decoded(field): field for field in fields}
    assert len(constants) == len(fields) == 1302
    for constant, field in constants.items():
        assert atari_inspection.arm64_logical_constant(constant) == field
        for bit in range(32):
            other = constant ^ 1 << bit
            assert atari_inspection.arm64_logical_constant(other) == constants.get(other)


@pytest.mark.parametrize("skipped", [0, 1, MEBIBYTE // 4 - 2])
def test_conditional_jumps(skipped: int) -> None:
    """CBZ, and the skipped instructions."""
    code = atari_inspection.arm64_jump(skipped, far=False)
    assert code[:4] == (0x34000003 | skipped + 1 << 5).to_bytes(4, "little")
    assert len(code) == 4 * (skipped + 1)


def test_conditional_jumps_that_lead_too_far() -> None:
    """Such a jump is refused; with `far`, the opposite jump leads over a jump of longer reach."""
    with pytest.raises(RuntimeError, match="a jump leads too far"):
        atari_inspection.arm64_jump(MEBIBYTE // 4 - 1, far=False)
    code = atari_inspection.arm64_jump(MEBIBYTE // 4 - 1, far=True)
    assert code[:8] == struct.pack("<II", 0x35000043, 0x14000000 | MEBIBYTE // 4)  # CBNZ, B
