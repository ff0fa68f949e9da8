#!/usr/bin/env python
"""Writes atari/emulator/handlers.def: which instructions the fast interpreter knows, and which pairs it fuses.

usage: scripts/make-handlers.py [PAIR_COUNTS]

Single handlers follow from the table of opcodes: every documented instruction, once for each kind of operand that is
worth code of its own. Pairs come from PAIR_COUNTS, lines of `count first second` as `count_pairs` prints them (see
tests/instructions); the most frequent are kept. Without PAIR_COUNTS the pairs stay as they are.
"""

import re
import sys
from pathlib import Path

EMULATOR = Path(__file__).parent.parent / "atari" / "emulator"
PAIRS = 300

READS = "ADC AND BIT CMP CPX CPY EOR LDA LDX LDY ORA SBC".split()
STORES = "STA STX STY".split()
MODIFIES = "ASL DEC INC LSR ROL ROR".split()
BRANCHES = "BCC BCS BEQ BMI BNE BPL BVC BVS".split()
IMPLIED = "CLC CLD CLI CLV DEX DEY INX INY NOP PHA PHP PLA PLP RTS SEC SED SEI TAX TAY TSX TXA TXS TYA".split()

# The kinds of operand (decoder.hpp says what each is), by addressing form.
READ_MODES = {
    "Imm": ["Imm"],
    "Zp": ["Ram", "PortZ"],
    "ZpX": ["RamX"],
    "ZpY": ["RamY"],
    "Abs": ["Fixed", "RamA", "Timer", "Dpc", "PortA"],
    "AbsX": ["RomX", "AnyX"],
    "AbsY": ["RomY", "AnyY"],
    "IndX": ["IndX"],
    "IndY": ["IndY"],
}
STORE_MODES = {
    "Zp": ["Ram", "Tia", "Strobe", "Motion", "Hmove", "Ctrlpf", "Grp0", "Grp1", "Wsync", "PortZ"],
    "ZpX": ["RamX"],
    "ZpY": ["RamY"],
    "Abs": ["RamA", "PortA"],
    "AbsX": ["AnyX"],
    "AbsY": ["AnyY"],
    "IndX": ["IndX"],
    "IndY": ["IndY"],
}
MODIFY_MODES = {"Zp": ["Ram"], "ZpX": ["RamX"], "Acc": ["Acc"]}

NEVER_FIRST = {"JMP", "JSR", "RTS", *BRANCHES}
"""After these the next instruction is elsewhere (or is not known to be the next)."""


def opcodes() -> list[tuple[str, str]]:
    """Operation and form of the 256 opcodes."""
    text = (EMULATOR / "opcodes.def").read_text()
    return re.findall(r"^OPCODE\(0x\w\w, (\w+), (\w+),", text, re.M)


def singles() -> list[tuple[str, str]]:
    """Operation and kind of operand of each handler of one instruction."""
    found = {}
    for operation, form in opcodes():
        if operation in READS:
            modes = READ_MODES[form]
        elif operation in STORES:
            modes = STORE_MODES[form]
        elif operation in MODIFIES:
            modes = MODIFY_MODES.get(form, [])
        elif operation in BRANCHES:
            modes = ["Rel"]
        elif operation in IMPLIED and form == "Imp":
            modes = ["Imp"]
        elif operation in ("JMP", "JSR"):
            modes = {"Abs": ["Near", "Far"], "Ind": ["Ind"]}[form]
        else:
            modes = []
        for mode in modes:
            found[operation, mode] = None
    return sorted(found)


def pairs(counts: Path, known: set[str]) -> list[tuple[str, str]]:
    """The most frequent pairs whose first instruction always goes on to the second."""
    rows = [line.split() for line in counts.read_text().splitlines()]
    ranked = sorted(((int(count), first, second) for count, first, second in rows), reverse=True)
    chosen = [
        (first, second)
        for _, first, second in ranked
        if first in known and second in known and first.split("_")[0] not in NEVER_FIRST
    ]
    return sorted(chosen[:PAIRS])


def main() -> None:
    """Write the file anew."""
    path = EMULATOR / "handlers.def"
    known = singles()
    if len(sys.argv) > 1:
        fused = pairs(Path(sys.argv[1]), {f"{operation}_{mode}" for operation, mode in known})
    elif path.exists():
        rows = re.findall(r"^PAIR\((\w+), (\w+), (\w+), (\w+)\)", path.read_text(), re.M)
        fused = [(f"{a}_{b}", f"{c}_{d}") for a, b, c, d in rows]
    else:
        fused = []
    lines = [
        "// Made by scripts/make-handlers.py. The instructions of the fast interpreter, a row a handler:",
        "//   SINGLE(operation, kind of operand)",
        "//   PAIR(operation, kind of operand, operation, kind of operand)",
        "",
        *(f"SINGLE({operation}, {mode})" for operation, mode in known),
        "",
        *("PAIR({}, {}, {}, {})".format(*first.split("_"), *second.split("_")) for first, second in fused),
    ]
    path.write_text("\n".join(lines) + "\n")
    print(f"{len(known)} single handlers, {len(fused)} pairs")


if __name__ == "__main__":
    main()
