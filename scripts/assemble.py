#!/usr/bin/env python
"""A small 6502 assembler: enough for an Atari cartridge, and for reading how one works.

usage: scripts/assemble.py SOURCE.asm OUTPUT.bin

A line is `label:`, `NAME = expression`, a directive or an instruction, each with an optional `; comment`:

    .org $F000            where the next byte goes; the output begins at the first .org
    .byte 1, $7E, %1010   bytes
    .word Start           16-bit words, low byte first
    lda #5                immediate;  lda score  zero page or absolute, as the value needs
    sta HMP0,x            indexed;  lda (ptr),y  and  lda (ptr,x)  indirect;  asl  the accumulator
    bne Loop              relative

Expressions are numbers (12, $0C, %1100), names, `+`, `-`, and a leading `<` or `>` for the low or high byte. The
documented opcodes are those of `atari/emulator/machine/cpu/opcodes.def`.
"""

import argparse
import re
import sys
from dataclasses import dataclass
from pathlib import Path

OPCODES = Path(__file__).parent.parent / "atari" / "emulator" / "machine" / "cpu" / "opcodes.def"
UNDOCUMENTED = set("ANC ANE ARR ASR DCP ISB JAM LAS LAX LXA RLA RRA SAX SBX SHA SHS SHX SHY SLO SRE".split())
LENGTHS = {"Imp": 1, "Acc": 1, "Abs": 3, "AbsX": 3, "AbsY": 3, "Ind": 3}
WIDER = {"Zp": "Abs", "ZpX": "AbsX", "ZpY": "AbsY"}
FORMS = (  # the shape of an operand, and the forms it can be
    (r"#(.+)", ("Imm",)),
    (r"\((.+),x\)", ("IndX",)),
    (r"\((.+)\),y", ("IndY",)),
    (r"\((.+)\)", ("Ind",)),
    (r"(.+),x", ("ZpX", "AbsX")),
    (r"(.+),y", ("ZpY", "AbsY")),
    (r"(.+)", ("Rel", "Zp", "Abs")),
)


class AssemblyError(Exception):
    """A line that cannot be assembled; the text names it."""


@dataclass(frozen=True)
class Item:
    """A piece of output: its address, its line in the source, and its instruction or directive."""

    address: int
    number: int
    operation: str
    form: str
    operands: tuple[str, ...]


def load_opcodes() -> dict[tuple[str, str], int]:
    """(mnemonic, addressing form) -> opcode, of the documented instructions."""
    rows = re.findall(r"^OPCODE\(0x(\w\w), (\w+), (\w+)", OPCODES.read_text(), re.M)
    table: dict[tuple[str, str], int] = {}
    for code, mnemonic, form in rows:
        documented = mnemonic not in UNDOCUMENTED and (mnemonic != "NOP" or code == "EA")
        if (documented and (mnemonic, form) != ("SBC", "Imm")) or code == "E9":
            table[mnemonic, form] = int(code, 16)
    return table


def assemble(source: str) -> bytes:
    """Assemble the text of a program.

    Raises:
        AssemblyError: a line is wrong; the text says which and why.
    """
    opcodes = load_opcodes()
    names: dict[str, int] = {}
    items: list[Item] = []
    address: int | None = None
    for number, line in enumerate(source.splitlines(), 1):
        text = line.split(";")[0].strip()
        if match := re.fullmatch(r"(\w+)\s*=\s*(.+)", text):
            names[match[1]] = _evaluate(match[2], names, number)
            continue
        if match := re.match(r"(\w+):\s*", text):
            names[match[1]] = _known(address, number)
            text = text[match.end() :]
        if not text:
            continue
        operation, _, rest = text.partition(" ")
        if operation == ".org":
            address = _evaluate(rest, names, number)
            continue
        item = _item(_known(address, number), number, operation.upper(), rest.strip(), names, opcodes)
        items.append(item)
        address = item.address + _length(item)
    return _emit(items, names, opcodes)


def _item(
    address: int, number: int, operation: str, rest: str, names: dict[str, int], opcodes: dict[tuple[str, str], int]
) -> Item:
    if operation in (".BYTE", ".WORD"):
        return Item(address, number, operation, "", tuple(part.strip() for part in rest.split(",")))
    forms = {form for mnemonic, form in opcodes if mnemonic == operation}
    if not forms:
        raise AssemblyError(f"line {number}: {operation} is no instruction")
    if not rest or rest.lower() == "a":
        form = next((form for form in ("Imp", "Acc") if form in forms), None)
        return Item(address, number, operation, _needed(form, operation, number), ())
    for pattern, candidates in FORMS:
        match = re.fullmatch(pattern, rest, re.I)
        if match:
            form = next((form for form in candidates if form in forms), None)
            if form in WIDER and (WIDER[form] in forms) and not _fits_zero_page(match[1], names):
                form = WIDER[form]
            return Item(address, number, operation, _needed(form, operation, number), (match[1],))
    raise AssemblyError(f"line {number}: cannot read {rest!r}")


def _needed(form: str | None, operation: str, number: int) -> str:
    if form is None:
        raise AssemblyError(f"line {number}: {operation} does not take such an operand")
    return form


def _fits_zero_page(expression: str, names: dict[str, int]) -> bool:
    """Whether an operand is already defined and below 256; labels further down count as above."""
    try:
        return _evaluate(expression, names, 0) < 256
    except AssemblyError:
        return False


def _length(item: Item) -> int:
    if item.operation in (".BYTE", ".WORD"):
        return len(item.operands) * (1 if item.operation == ".BYTE" else 2)
    return LENGTHS.get(item.form, 2)


def _emit(items: list[Item], names: dict[str, int], opcodes: dict[tuple[str, str], int]) -> bytes:
    if not items:
        raise AssemblyError("the program is empty")
    start = items[0].address
    image = bytearray(max(item.address + _length(item) for item in items) - start)
    for item in items:
        data = _bytes(item, names, opcodes)
        at = item.address - start
        if at < 0:
            raise AssemblyError(f"line {item.number}: .org goes back before the first one")
        image[at : at + len(data)] = data
    return bytes(image)


def _bytes(item: Item, names: dict[str, int], opcodes: dict[tuple[str, str], int]) -> bytes:
    values = [_evaluate(operand, names, item.number) for operand in item.operands]
    if item.operation == ".WORD":
        return b"".join((value & 0xFFFF).to_bytes(2, "little") for value in values)
    if item.operation == ".BYTE":
        return bytes(_byte(value, item.number) for value in values)
    code = bytes([opcodes[item.operation, item.form]])
    if item.form == "Rel":
        offset = values[0] - (item.address + 2)
        if not -128 <= offset <= 127:
            raise AssemblyError(f"line {item.number}: the branch is too far ({offset} bytes)")
        return code + (offset & 0xFF).to_bytes(1, "little")
    if _length(item) == 3:
        return code + (values[0] & 0xFFFF).to_bytes(2, "little")
    return code + bytes(_byte(value, item.number) for value in values)


def _byte(value: int, number: int) -> int:
    if not -128 <= value <= 255:
        raise AssemblyError(f"line {number}: {value} does not fit into a byte")
    return value & 0xFF


def _known(address: int | None, number: int) -> int:
    if address is None:
        raise AssemblyError(f"line {number}: .org must come first")
    return address


def _evaluate(expression: str, names: dict[str, int], number: int) -> int:
    text = expression.strip()
    part, text = (text[0], text[1:]) if text[:1] in ("<", ">") else ("", text)
    total = 0
    for sign, term in re.findall(r"([+-]?)\s*([\w$%]+)", text):
        total += (-1 if sign == "-" else 1) * _term(term, names, number)
    return {"<": total & 0xFF, ">": total >> 8, "": total}[part]


def _term(term: str, names: dict[str, int], number: int) -> int:
    try:
        if term.startswith("$"):
            return int(term[1:], 16)
        if term.startswith("%"):
            return int(term[1:], 2)
        if term.isdigit():
            return int(term)
    except ValueError:
        raise AssemblyError(f"line {number}: {term!r} is no number") from None
    if term not in names:
        raise AssemblyError(f"line {number}: {term!r} is not defined")
    return names[term]


def main() -> int:
    """Assemble a file into another."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", type=Path)
    parser.add_argument("output", type=Path)
    options = parser.parse_args()
    try:
        image = assemble(options.source.read_text(encoding="utf-8"))
    except (AssemblyError, OSError) as error:
        print(f"assemble: error: {error}", file=sys.stderr)
        return 1
    options.output.write_bytes(image)
    print(f"{options.output}: {len(image)} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
