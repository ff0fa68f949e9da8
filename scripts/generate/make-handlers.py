#!/usr/bin/env python
"""Writes handlers.def of the fast interpreter: its handlers of single instructions and its superinstructions.

Single handlers follow from the table of opcodes: every documented instruction, once for each kind of operand that is
worth code of its own. A superinstruction is a pair of instructions. COUNTS has lines of `count first second ...`, as
tests/instructions/runs.cpp prints them: how often instructions run one after the other. Without COUNTS the
superinstructions do not change.
"""

import argparse
import re
from collections import Counter
from itertools import groupby, pairwise
from pathlib import Path
from textwrap import wrap

EMULATOR = Path(__file__).parents[2] / "atari" / "emulator"
PAIRS = 400
"""The number of superinstructions. More would take compilers minutes and save little where there is translated code
(docs/performance.md)."""

READS = "ADC AND BIT CMP CPX CPY EOR LDA LDX LDY ORA SBC".split()
STORES = "STA STX STY".split()
MODIFIES = "ASL DEC INC LSR ROL ROR".split()
BRANCHES = "BCC BCS BEQ BMI BNE BPL BVC BVS".split()
IMPLIED = "CLC CLD CLI CLV DEX DEY INX INY NOP PHA PHP PLA PLP RTS SEC SED SEI TAX TAY TSX TXA TXS TYA".split()

# The kinds of operand (decoder.hpp describes each), by addressing form.
READ_MODES = {
    "Imm": ["Imm"],
    "Zp": ["Ram", "Input", "PortZ"],
    "ZpX": ["RamX"],
    "ZpY": ["RamY"],
    "Abs": ["Fixed", "RamA", "Timer", "Dpc", "PortA"],
    "AbsX": ["RomX", "AnyX"],
    "AbsY": ["RomY", "AnyY"],
    "IndX": ["IndX"],
    "IndY": ["IndY"],
}
STORE_MODES = {
    "Zp": "Ram Tia Strobe Nusiz Motion Hmove Ctrlpf Grp0 Grp1 Wsync Sound Hmclr Cxclr PortZ".split(),
    "ZpX": ["RamX"],
    "ZpY": ["RamY"],
    "Abs": ["RamA", "TiaA", "Grp0A", "Grp1A", "PortA"],
    "AbsX": ["AnyX"],
    "AbsY": ["AnyY"],
    "IndX": ["IndX"],
    "IndY": ["IndY"],
}
MODIFY_MODES = {"Zp": ["Ram"], "ZpX": ["RamX"], "Acc": ["Acc"]}

GROUPS = {
    "SHIFT": ["Acc", "Ram", "RamX"],
    "CALCULATION": sorted({kind for kinds in READ_MODES.values() for kind in kinds} - {"RamY"}),
    "READ": sorted(READ_MODES["Zp"] + READ_MODES["Abs"]),
    "STORE": sorted(STORE_MODES["Zp"] + STORE_MODES["Abs"]),
}
"""Kinds of operand that several operations have. The file has a macro for each group."""

LAST = {"JMP", "JSR", "RTS", *BRANCHES}
"""Instructions after which the next one may be at another address."""


def opcodes() -> list[tuple[str, str]]:
    """Operation and form of the 256 opcodes."""
    text = (EMULATOR / "machine" / "cpu" / "opcodes.def").read_text()
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


def rows_of_singles(singles: list[tuple[str, str]]) -> list[str]:
    """The rows of the single handlers in the file. An operation has the row of the first group that fits."""
    rows = []
    for operation, found in groupby(singles, lambda single: single[0]):
        kinds = [kind for _, kind in found]
        group = next((name for name, common in GROUPS.items() if set(common) <= set(kinds)), None)
        if group:
            rows.append(f"{group}({operation})")
            kinds = [kind for kind in kinds if kind not in GROUPS[group]]
        rows += [f"SINGLE({operation}, {kind})" for kind in kinds]
    return rows


def macro_of(group: str) -> list[str]:
    """The lines that define the macro of a group."""
    text = " ".join(f"SINGLE(operation,\xa0{kind})" for kind in GROUPS[group])
    lines = [f"#define {group}(operation)", *wrap(text, 112, initial_indent="    ", subsequent_indent="    ")]
    return " \\\n".join(lines).replace("\xa0", " ").split("\n")


Runs = list[tuple[float, list[str]]]
Pair = tuple[str, str]


def uses(runs: Runs, fused: set[Pair]) -> Counter[Pair]:
    """The uses of each superinstruction: from a run's start, the next two instructions are one if `fused` has them."""
    found = Counter[Pair]()
    for count, names in runs:
        at = 0
        while at + 1 < len(names):
            pair = names[at], names[at + 1]
            if pair in fused:
                found[pair] += count
                at += 1
            at += 1
    return found


def pairs(counts: Path, known: set[str]) -> list[Pair]:
    """The pairs that save most dispatches, sorted by name.

    These are not the most frequent pairs: where A, B and C follow each other, B and C are not fused if A and B are. So
    the function begins with all pairs whose first instruction always continues to the second, and repeatedly removes
    the pairs that are used least.
    """
    rows = [line.split() for line in counts.read_text().splitlines()]
    runs = [(float(count), names) for count, *names in rows]
    fused = {pair for _, names in runs for pair in pairwise(names) if known.issuperset(pair)}
    fused = {pair for pair in fused if pair[0].split("_")[0] not in LAST}
    while len(fused) > PAIRS:
        found = uses(runs, fused)
        ranked = sorted(fused, key=lambda pair: (found[pair], pair))
        fused = fused - set(ranked[: min(len(fused) - PAIRS, len(fused) // 32 + 1)])
    return sorted(fused)


def rows_of(pairs: list[Pair]) -> list[str]:
    """The rows of the superinstructions in the file."""
    return ["PAIR({})".format(", ".join(name.replace("_", ", ") for name in pair)) for pair in pairs]


def main() -> None:
    """Write the file anew."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "counts", nargs="?", type=Path, help="how often runs of instructions occur (default: keep the pairs)"
    )
    counts: Path | None = parser.parse_args().counts
    path = EMULATOR / "fast" / "interpreter" / "handlers.def"
    known = singles()
    if counts:
        fused = pairs(counts, {f"{operation}_{mode}" for operation, mode in known})
    else:
        rows = re.findall(r"^PAIR\((\w.*)\)", path.read_text(), re.M) if path.exists() else []
        fused = [tuple(re.findall(r"(\w+), (\w+)", row)) for row in rows]
        fused = [tuple(f"{operation}_{mode}" for operation, mode in pair) for pair in fused]
    lines = [
        "// Made by scripts/generate/make-handlers.py. The instructions of the fast interpreter, a row a handler:",
        "//   SINGLE(operation, kind of operand)",
        "//   PAIR(operation, kind of operand, operation, kind of operand)",
        "// A row of a group stands for a SINGLE of each kind of operand in the group.",
        "// ATARI_NO_PAIRS leaves pairs out: instrumented builds take too long with them. All macros end here.",
        "#ifdef ATARI_NO_PAIRS",
        "#undef PAIR",
        "#define PAIR(...)",
        "#endif",
        "",
        *(line for group in GROUPS for line in macro_of(group)),
        "",
        *rows_of_singles(known),
        "",
        *rows_of(fused),
        "",
        *(f"#undef {name}" for name in ("SINGLE", "PAIR", *GROUPS)),
    ]
    path.write_text("\n".join(lines) + "\n")
    print(f"{len(known)} single handlers, {len(fused)} pairs")


if __name__ == "__main__":
    main()
