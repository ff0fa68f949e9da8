// The 6507 interpreter of the reference core. The fast interpreter and the translated code are tested against it.
//
// Opcodes are rows of opcodes.def. No interrupts exist; there are no dummy accesses except those in this file.
#include "console.hpp"
#include "opcodes.hpp"

namespace atari {
namespace {

constexpr bool is_store(int op) {
    return op == STA || op == STX || op == STY || op == SAX || op == SHA || op == SHS || op == SHX || op == SHY;
}

constexpr bool is_read_modify_write(int op, int form) {
    return form != Acc && (op == ASL || op == LSR || op == ROL || op == ROR || op == INC || op == DEC || op == SLO ||
                           op == RLA || op == SRE || op == RRA || op == DCP || op == ISB);
}

void set_nz(Cpu& cpu, uint8_t value) {
    cpu.n = value & 0x80;
    cpu.z = value == 0;
}

void compare(Cpu& cpu, uint8_t reg, uint8_t operand) {
    cpu.c = reg >= operand;
    set_nz(cpu, static_cast<uint8_t>(reg - operand));
}

uint8_t status(const Cpu& cpu) {
    return static_cast<uint8_t>(cpu.n << 7 | cpu.v << 6 | 0x30 | cpu.d << 3 | cpu.i << 2 | cpu.z << 1 | cpu.c);
}

void set_status(Cpu& cpu, uint8_t value) {
    cpu.n = value & 0x80;
    cpu.v = value & 0x40;
    cpu.d = value & 0x08;
    cpu.i = value & 0x04;
    cpu.z = value & 0x02;
    cpu.c = value & 0x01;
}

// Decimal mode, invalid digits included: converts two digits to a number, and a number to two digits.
int from_digits(int byte) { return (byte >> 4) * 10 + (byte & 15); }
int to_digits(int number) { return (number % 100 / 10) << 4 | number % 10; }

// Returns the new value of a memory byte or the accumulator after a shift or an increment, and sets carry, N and Z.
template <int op>
uint8_t modify(Cpu& cpu, uint8_t old) {
    int value = old;
    if constexpr (op == ASL || op == SLO) {
        value = old << 1;
        cpu.c = old & 0x80;
    } else if constexpr (op == LSR || op == SRE) {
        value = old >> 1;
        cpu.c = old & 1;
    } else if constexpr (op == ROL || op == RLA) {
        value = old << 1 | cpu.c;
        cpu.c = old & 0x80;
    } else if constexpr (op == ROR || op == RRA) {
        value = old >> 1 | cpu.c << 7;
        cpu.c = old & 1;
    } else if constexpr (op == INC || op == ISB) {
        value = old + 1;
    } else {
        value = old - 1;
    }
    return static_cast<uint8_t>(value);
}

}  // namespace

void Console::push(uint8_t value) { write(static_cast<uint16_t>(0x100 | m_.cpu.sp--), value); }

uint8_t Console::pull() { return read(static_cast<uint16_t>(0x100 | ++m_.cpu.sp)); }

void Console::adc(uint8_t operand) {
    Cpu& cpu = m_.cpu;
    const uint8_t old = cpu.a;
    if (cpu.d) {
        const int sum = from_digits(old) + from_digits(operand) + cpu.c;
        cpu.c = sum > 99;
        cpu.a = static_cast<uint8_t>(to_digits(sum & 0xff));
        cpu.v = (old ^ cpu.a) & (cpu.a ^ operand) & 0x80;
    } else {
        const int sum = old + operand + cpu.c;
        cpu.c = sum > 255;
        cpu.a = static_cast<uint8_t>(sum);
        cpu.v = (old ^ cpu.a) & (operand ^ cpu.a) & 0x80;
    }
    set_nz(cpu, cpu.a);
}

void Console::sbc(uint8_t operand) {
    Cpu& cpu = m_.cpu;
    if (!cpu.d) return adc(static_cast<uint8_t>(~operand));
    const uint8_t old = cpu.a;
    int difference = from_digits(old) - from_digits(operand) - !cpu.c;
    if (difference < 0) difference += 100;
    // With invalid digits the value may still be negative. ALE then reads before the start of a table, with this
    // result.
    cpu.a = static_cast<uint8_t>(difference >= 0 ? to_digits(difference) : from_digits(256 + difference));
    cpu.c = old >= operand + !cpu.c;
    cpu.v = (old ^ cpu.a) & (cpu.a ^ operand) & 0x80;
    set_nz(cpu, cpu.a);
}

void Console::arr(uint8_t operand) {
    Cpu& cpu = m_.cpu;
    const int masked = cpu.a & operand;
    int result = masked >> 1 | cpu.c << 7;
    if (cpu.d) {
        cpu.n = cpu.c;
        cpu.z = result == 0;
        cpu.v = (masked ^ result) & 0x40;
        if ((masked & 15) + (masked & 1) > 5) result = (result & 0xf0) | ((result + 6) & 15);
        cpu.c = (masked & 0xf0) + (masked & 0x10) > 0x50;
        if (cpu.c) result = (result + 0x60) & 0xff;
    } else {
        set_nz(cpu, static_cast<uint8_t>(result));
        cpu.c = result & 0x40;
        cpu.v = (result >> 6 ^ result >> 5) & 1;
    }
    cpu.a = static_cast<uint8_t>(result);
}

void Console::branch(bool taken) {
    const auto offset = static_cast<int8_t>(fetch());
    if (!taken) return;
    const auto target = static_cast<uint16_t>(m_.cpu.pc + offset);
    m_.cycles += (target ^ m_.cpu.pc) & 0xff00 ? 2 : 1;
    m_.cpu.pc = target;
}

// Reads the operand bytes and pointers of a form. `penalty`: crossing a page while indexing costs a cycle.
template <int form>
uint16_t Console::effective_address(int penalty) {
    const auto word = [&](uint8_t low, uint8_t high) { return static_cast<uint16_t>(low | high << 8); };
    const auto indexed = [&](uint16_t base, uint8_t index) {
        if (penalty && ((base ^ (base + index)) & 0x1ff00)) ++m_.cycles;
        return static_cast<uint16_t>(base + index);
    };
    if constexpr (form == Imm) return m_.cpu.pc++;
    const uint8_t low = fetch();
    if constexpr (form == Zp) return low;
    if constexpr (form == ZpX) return (low + m_.cpu.x) & 0xff;
    if constexpr (form == ZpY) return (low + m_.cpu.y) & 0xff;
    if constexpr (form == IndX || form == IndY) {
        const uint16_t pointer = form == IndX ? (low + m_.cpu.x) & 0xff : low;
        const uint8_t target_low = read(pointer);
        const uint8_t target_high = read(static_cast<uint16_t>(pointer + 1));  // $FF is followed by $0100, a TIA read
        return form == IndX ? word(target_low, target_high) : indexed(word(target_low, target_high), m_.cpu.y);
    }
    const uint16_t address = word(low, fetch());
    if constexpr (form == AbsX) return indexed(address, m_.cpu.x);
    if constexpr (form == AbsY) return indexed(address, m_.cpu.y);
    return address;
}

template <int op, int form>
void Console::execute(int penalty) {
    Cpu& cpu = m_.cpu;
    if constexpr (is_store(op)) {
        const uint16_t address = effective_address<form>(0);
        const auto high_plus_one = static_cast<uint8_t>((address >> 8) + 1);
        if constexpr (op == STA) write(address, cpu.a);
        if constexpr (op == STX) write(address, cpu.x);
        if constexpr (op == STY) write(address, cpu.y);
        if constexpr (op == SAX) write(address, cpu.a & cpu.x);
        if constexpr (op == SHA) write(address, cpu.a & cpu.x & high_plus_one);
        if constexpr (op == SHX) write(address, cpu.x & high_plus_one);
        if constexpr (op == SHY) write(address, cpu.y & high_plus_one);
        if constexpr (op == SHS) {
            cpu.sp = cpu.a & cpu.x;
            write(address, cpu.sp & high_plus_one);
        }
    } else if constexpr (is_read_modify_write(op, form)) {
        const uint16_t address = effective_address<form>(0);
        const uint8_t value = modify<op>(cpu, read(address));
        write(address, value);
        if constexpr (op == SLO) set_nz(cpu, cpu.a |= value);
        else if constexpr (op == RLA) set_nz(cpu, cpu.a &= value);
        else if constexpr (op == SRE) set_nz(cpu, cpu.a ^= value);
        else if constexpr (op == RRA) adc(value);
        else if constexpr (op == DCP) compare(cpu, cpu.a, value);
        else if constexpr (op == ISB) sbc(value);
        else set_nz(cpu, value);
    } else if constexpr (form == Acc) {
        set_nz(cpu, cpu.a = modify<op>(cpu, cpu.a));
    } else if constexpr (form == Rel) {
        if constexpr (op == BPL) branch(!cpu.n);
        if constexpr (op == BMI) branch(cpu.n);
        if constexpr (op == BVC) branch(!cpu.v);
        if constexpr (op == BVS) branch(cpu.v);
        if constexpr (op == BCC) branch(!cpu.c);
        if constexpr (op == BCS) branch(cpu.c);
        if constexpr (op == BNE) branch(!cpu.z);
        if constexpr (op == BEQ) branch(cpu.z);
    } else if constexpr (op == JMP && form == Abs) {
        cpu.pc = effective_address<Abs>(0);
    } else if constexpr (op == JMP) {
        const uint16_t pointer = effective_address<Abs>(0);
        const uint8_t low = read(pointer);  // the high byte comes from the same page, as on the real chip
        cpu.pc = static_cast<uint16_t>(low | read((pointer & 0xff) == 0xff ? pointer & 0xff00 : pointer + 1) << 8);
    } else if constexpr (op == JSR) {
        const uint8_t low = fetch();
        read(0x100 | cpu.sp);
        push(static_cast<uint8_t>(cpu.pc >> 8));
        push(static_cast<uint8_t>(cpu.pc));
        cpu.pc = static_cast<uint16_t>(low | read(cpu.pc) << 8);
    } else if constexpr (op == RTS) {
        read(0x100 | cpu.sp);
        const uint8_t low = pull();
        cpu.pc = static_cast<uint16_t>(low | pull() << 8);
        read(cpu.pc++);
    } else if constexpr (op == RTI) {
        read(0x100 | cpu.sp);
        set_status(cpu, pull());
        const uint8_t low = pull();
        cpu.pc = static_cast<uint16_t>(low | pull() << 8);
    } else if constexpr (op == BRK) {
        fetch();
        push(static_cast<uint8_t>(cpu.pc >> 8));
        push(static_cast<uint8_t>(cpu.pc));
        push(status(cpu));
        cpu.i = true;
        const uint8_t low = read(0xfffe);
        cpu.pc = static_cast<uint16_t>(low | read(0xffff) << 8);
    } else if constexpr (op == JAM) {
        cpu.jammed = true;
    } else if constexpr (op == PHA) {
        push(cpu.a);
    } else if constexpr (op == PHP) {
        push(status(cpu));
    } else if constexpr (op == PLA) {
        read(0x100 | cpu.sp);
        set_nz(cpu, cpu.a = pull());
    } else if constexpr (op == PLP) {
        read(0x100 | cpu.sp);
        set_status(cpu, pull());
    } else if constexpr (form == Imp) {
        if constexpr (op == TAX) set_nz(cpu, cpu.x = cpu.a);
        if constexpr (op == TAY) set_nz(cpu, cpu.y = cpu.a);
        if constexpr (op == TXA) set_nz(cpu, cpu.a = cpu.x);
        if constexpr (op == TYA) set_nz(cpu, cpu.a = cpu.y);
        if constexpr (op == TSX) set_nz(cpu, cpu.x = cpu.sp);
        if constexpr (op == TXS) cpu.sp = cpu.x;
        if constexpr (op == INX) set_nz(cpu, ++cpu.x);
        if constexpr (op == INY) set_nz(cpu, ++cpu.y);
        if constexpr (op == DEX) set_nz(cpu, --cpu.x);
        if constexpr (op == DEY) set_nz(cpu, --cpu.y);
        if constexpr (op == CLC) cpu.c = false;
        if constexpr (op == SEC) cpu.c = true;
        if constexpr (op == CLI) cpu.i = false;
        if constexpr (op == SEI) cpu.i = true;
        if constexpr (op == CLV) cpu.v = false;
        if constexpr (op == CLD) cpu.d = false;
        if constexpr (op == SED) cpu.d = true;
    } else {
        const uint8_t o = read(effective_address<form>(penalty));
        if constexpr (op == LDA) set_nz(cpu, cpu.a = o);
        if constexpr (op == LDX) set_nz(cpu, cpu.x = o);
        if constexpr (op == LDY) set_nz(cpu, cpu.y = o);
        if constexpr (op == LAX) set_nz(cpu, cpu.a = cpu.x = o);
        if constexpr (op == AND) set_nz(cpu, cpu.a &= o);
        if constexpr (op == ORA) set_nz(cpu, cpu.a |= o);
        if constexpr (op == EOR) set_nz(cpu, cpu.a ^= o);
        if constexpr (op == ADC) adc(o);
        if constexpr (op == SBC) sbc(o);
        if constexpr (op == CMP) compare(cpu, cpu.a, o);
        if constexpr (op == CPX) compare(cpu, cpu.x, o);
        if constexpr (op == CPY) compare(cpu, cpu.y, o);
        if constexpr (op == BIT) {
            cpu.z = (cpu.a & o) == 0;
            cpu.n = o & 0x80;
            cpu.v = o & 0x40;
        }
        if constexpr (op == ANC) {
            set_nz(cpu, cpu.a &= o);
            cpu.c = cpu.n;
        }
        if constexpr (op == ASR) {
            cpu.a &= o;
            cpu.c = cpu.a & 1;
            set_nz(cpu, cpu.a >>= 1);
        }
        if constexpr (op == ARR) arr(o);
        if constexpr (op == ANE) set_nz(cpu, cpu.a = (cpu.a | 0xee) & cpu.x & o);
        if constexpr (op == LXA) set_nz(cpu, cpu.a = cpu.x = (cpu.a | 0xee) & o);
        if constexpr (op == LAS) set_nz(cpu, cpu.a = cpu.x = cpu.sp = cpu.sp & o);
        if constexpr (op == SBX) {
            const int difference = (cpu.a & cpu.x) - o;
            cpu.c = difference >= 0;
            set_nz(cpu, cpu.x = static_cast<uint8_t>(difference));
        }
    }
}

void Console::run_instruction() {
    switch (fetch()) {
#define OPCODE(code, operation, form, cost, penalty) \
    case code:                                       \
        m_.cycles += cost;                           \
        execute<operation, form>(penalty);           \
        break;
#include "opcodes.def"
#undef OPCODE
    }
}

void Console::run_cpu() {
    m_.cpu.stop = false;
    for (int left = kInstructionLimit; left > 0 && !m_.cpu.stop && !m_.cpu.jammed; --left) run_instruction();
}

}  // namespace atari
