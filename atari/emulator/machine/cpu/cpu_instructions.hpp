// The 6507's instructions, on any bus: the definitions of `Cpu::run_instruction` and `Cpu::run_frame` (cpu.hpp). Tests
// compare the fast interpreter and the translated code with them.
//
// Opcodes are rows of opcodes.def. No interrupts exist; there are no dummy accesses except those in this file.
#pragma once

#include "cpu.hpp"
#include "opcodes.hpp"

namespace atari {

constexpr bool only_writes(int op) {
    return op == STA || op == STX || op == STY || op == SAX || op == SHA || op == SHS || op == SHX || op == SHY;
}

constexpr bool reads_and_writes(int op, int form) {
    return form != Acc && (op == ASL || op == LSR || op == ROL || op == ROR || op == INC || op == DEC || op == SLO ||
                           op == RLA || op == SRE || op == RRA || op == DCP || op == ISB);
}

// Returns the new value of a memory byte or the accumulator after a shift or an increment. A shift sets the carry.
template <int op>
uint8_t Cpu::modify(uint8_t old) {
    int value = old;
    if constexpr (op == ASL || op == SLO) {
        value = old << 1;
        c = old & 0x80;
    } else if constexpr (op == LSR || op == SRE) {
        value = old >> 1;
        c = old & 1;
    } else if constexpr (op == ROL || op == RLA) {
        value = old << 1 | c;
        c = old & 0x80;
    } else if constexpr (op == ROR || op == RRA) {
        value = old >> 1 | c << 7;
        c = old & 1;
    } else if constexpr (op == INC || op == ISB) {
        value = old + 1;
    } else {
        value = old - 1;
    }
    return static_cast<uint8_t>(value);
}

void Cpu::branch(auto& bus, bool taken) {
    const auto offset = static_cast<int8_t>(fetch(bus));
    if (!taken) return;
    const auto target = static_cast<uint16_t>(pc + offset);
    bus.spend((target ^ pc) & 0xff00 ? 2 : 1);
    pc = target;
}

// Reads the operand bytes and pointers of a form. `penalty`: crossing a page while indexing costs a cycle.
template <int form>
uint16_t Cpu::effective_address(auto& bus, int penalty) {
    const auto word = [&](uint8_t low, uint8_t high) { return static_cast<uint16_t>(low | high << 8); };
    const auto indexed = [&](uint16_t base, uint8_t index) {
        if (penalty && ((base ^ (base + index)) & 0x1ff00)) bus.spend(1);
        return static_cast<uint16_t>(base + index);
    };
    if constexpr (form == Imm) return pc++;
    const uint8_t low = fetch(bus);
    if constexpr (form == Zp) return low;
    if constexpr (form == ZpX) return (low + x) & 0xff;
    if constexpr (form == ZpY) return (low + y) & 0xff;
    if constexpr (form == IndX || form == IndY) {
        const uint16_t pointer = form == IndX ? (low + x) & 0xff : low;
        const uint8_t target_low = bus.read(pointer);
        // $FF is followed by $0100, a TIA read.
        const uint8_t target_high = bus.read(static_cast<uint16_t>(pointer + 1));
        return form == IndX ? word(target_low, target_high) : indexed(word(target_low, target_high), y);
    }
    const uint16_t address = word(low, fetch(bus));
    if constexpr (form == AbsX) return indexed(address, x);
    if constexpr (form == AbsY) return indexed(address, y);
    return address;
}

template <int op, int form>
void Cpu::execute(auto& bus, int penalty) {
    if constexpr (only_writes(op)) {
        const uint16_t address = effective_address<form>(bus, 0);
        const auto high_plus_one = static_cast<uint8_t>((address >> 8) + 1);
        if constexpr (op == STA) bus.write(address, a);
        if constexpr (op == STX) bus.write(address, x);
        if constexpr (op == STY) bus.write(address, y);
        if constexpr (op == SAX) bus.write(address, a & x);
        if constexpr (op == SHA) bus.write(address, a & x & high_plus_one);
        if constexpr (op == SHX) bus.write(address, x & high_plus_one);
        if constexpr (op == SHY) bus.write(address, y & high_plus_one);
        if constexpr (op == SHS) {
            sp = a & x;
            bus.write(address, sp & high_plus_one);
        }
    } else if constexpr (reads_and_writes(op, form)) {
        const uint16_t address = effective_address<form>(bus, 0);
        const uint8_t value = modify<op>(bus.read(address));
        bus.write(address, value);
        if constexpr (op == SLO) set_nz(a |= value);
        else if constexpr (op == RLA) set_nz(a &= value);
        else if constexpr (op == SRE) set_nz(a ^= value);
        else if constexpr (op == RRA) adc(value);
        else if constexpr (op == DCP) compare(a, value);
        else if constexpr (op == ISB) sbc(value);
        else set_nz(value);
    } else if constexpr (form == Acc) {
        set_nz(a = modify<op>(a));
    } else if constexpr (form == Rel) {
        if constexpr (op == BPL) branch(bus, !n);
        if constexpr (op == BMI) branch(bus, n);
        if constexpr (op == BVC) branch(bus, !v);
        if constexpr (op == BVS) branch(bus, v);
        if constexpr (op == BCC) branch(bus, !c);
        if constexpr (op == BCS) branch(bus, c);
        if constexpr (op == BNE) branch(bus, !z);
        if constexpr (op == BEQ) branch(bus, z);
    } else if constexpr (op == JMP && form == Abs) {
        pc = effective_address<Abs>(bus, 0);
    } else if constexpr (op == JMP) {
        const uint16_t pointer = effective_address<Abs>(bus, 0);
        const uint8_t low = bus.read(pointer);  // the high byte comes from the same page, as on the real chip
        pc = static_cast<uint16_t>(low | bus.read((pointer & 0xff) == 0xff ? pointer & 0xff00 : pointer + 1) << 8);
    } else if constexpr (op == JSR) {
        const uint8_t low = fetch(bus);
        bus.read(0x100 | sp);
        push(bus, static_cast<uint8_t>(pc >> 8));
        push(bus, static_cast<uint8_t>(pc));
        pc = static_cast<uint16_t>(low | bus.read(pc) << 8);
    } else if constexpr (op == RTS) {
        bus.read(0x100 | sp);
        const uint8_t low = pull(bus);
        pc = static_cast<uint16_t>(low | pull(bus) << 8);
        bus.read(pc++);
    } else if constexpr (op == RTI) {
        bus.read(0x100 | sp);
        set_status(pull(bus));
        const uint8_t low = pull(bus);
        pc = static_cast<uint16_t>(low | pull(bus) << 8);
    } else if constexpr (op == BRK) {
        fetch(bus);
        push(bus, static_cast<uint8_t>(pc >> 8));
        push(bus, static_cast<uint8_t>(pc));
        push(bus, status());
        i = true;
        const uint8_t low = bus.read(0xfffe);
        pc = static_cast<uint16_t>(low | bus.read(0xffff) << 8);
    } else if constexpr (op == JAM) {
        jammed = true;
    } else if constexpr (op == PHA) {
        push(bus, a);
    } else if constexpr (op == PHP) {
        push(bus, status());
    } else if constexpr (op == PLA) {
        bus.read(0x100 | sp);
        set_nz(a = pull(bus));
    } else if constexpr (op == PLP) {
        bus.read(0x100 | sp);
        set_status(pull(bus));
    } else if constexpr (form == Imp) {
        if constexpr (op == TAX) set_nz(x = a);
        if constexpr (op == TAY) set_nz(y = a);
        if constexpr (op == TXA) set_nz(a = x);
        if constexpr (op == TYA) set_nz(a = y);
        if constexpr (op == TSX) set_nz(x = sp);
        if constexpr (op == TXS) sp = x;
        if constexpr (op == INX) set_nz(++x);
        if constexpr (op == INY) set_nz(++y);
        if constexpr (op == DEX) set_nz(--x);
        if constexpr (op == DEY) set_nz(--y);
        if constexpr (op == CLC) c = false;
        if constexpr (op == SEC) c = true;
        if constexpr (op == CLI) i = false;
        if constexpr (op == SEI) i = true;
        if constexpr (op == CLV) v = false;
        if constexpr (op == CLD) d = false;
        if constexpr (op == SED) d = true;
    } else {
        const uint8_t o = bus.read(effective_address<form>(bus, penalty));
        if constexpr (op == LDA) set_nz(a = o);
        if constexpr (op == LDX) set_nz(x = o);
        if constexpr (op == LDY) set_nz(y = o);
        if constexpr (op == LAX) set_nz(a = x = o);
        if constexpr (op == AND) set_nz(a &= o);
        if constexpr (op == ORA) set_nz(a |= o);
        if constexpr (op == EOR) set_nz(a ^= o);
        if constexpr (op == ADC) adc(o);
        if constexpr (op == SBC) sbc(o);
        if constexpr (op == CMP) compare(a, o);
        if constexpr (op == CPX) compare(x, o);
        if constexpr (op == CPY) compare(y, o);
        if constexpr (op == BIT) {
            z = (a & o) == 0;
            n = o & 0x80;
            v = o & 0x40;
        }
        if constexpr (op == ANC) {
            set_nz(a &= o);
            c = n;
        }
        if constexpr (op == ASR) {
            a &= o;
            c = a & 1;
            set_nz(a >>= 1);
        }
        if constexpr (op == ARR) arr(o);
        if constexpr (op == ANE) set_nz(a = (a | 0xee) & x & o);
        if constexpr (op == LXA) set_nz(a = x = (a | 0xee) & o);
        if constexpr (op == LAS) set_nz(a = x = sp = sp & o);
        if constexpr (op == SBX) {
            const int difference = (a & x) - o;
            c = difference >= 0;
            set_nz(x = static_cast<uint8_t>(difference));
        }
    }
}

void Cpu::run_instruction(auto& bus) {
    switch (fetch(bus)) {
#define OPCODE(code, operation, form, cost, penalty) \
    case code:                                       \
        bus.spend(cost);                             \
        execute<operation, form>(bus, penalty);      \
        break;
#include "opcodes.def"
#undef OPCODE
    }
}

void Cpu::run_frame(auto& bus) {
    stop = false;
    for (int left = kInstructionLimit; left > 0 && !stop && !jammed; --left) run_instruction(bus);
}

}  // namespace atari
