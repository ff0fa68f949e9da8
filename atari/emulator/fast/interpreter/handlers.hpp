// The bodies of the handlers of the fast interpreter (interpreter.cpp), one for each operation and kind of operand.
//
// A handler either completes its instruction, or returns `kInterpret` before it has changed anything, so that the plain
// interpreter runs the instruction. A handler must have exactly the effect of the plain interpreter. Tests compare both
// frame by frame on all games, random ROMs and random programs (tests/emulator/test_fast_equals_plain.py).
#pragma once

#include "fast/fast_console.hpp"
#include "machine/inline.hpp"
#include "machine/cartridge/dpc.hpp"
#include "machine/cpu/opcodes.hpp"

namespace atari {

struct Registers {
    const DecodedInstruction* at;
    uint32_t cycles;
    uint32_t a, x, y;  // bytes
    uint32_t nz;       // Z is set if the low byte is 0; N is bit 7 or bit 8
    uint32_t carry;    // 0 or 1
};

enum Exit {
    kNext,       // continue at r.at
    kInterpret,  // fall back for the instruction at r.at; nothing has changed
    kLeave,      // the frame has ended, or the window shows another bank: check before continuing
    kLimit,      // the instruction limit may be near
};

constexpr bool is_read(int op) {
    return op == ADC || op == AND || op == BIT || op == CMP || op == CPX || op == CPY || op == EOR || op == LDA ||
           op == LDX || op == LDY || op == ORA || op == SBC;
}
constexpr bool is_store(int op) { return op == STA || op == STX || op == STY; }
constexpr bool is_modify(int op) { return op == ASL || op == DEC || op == INC || op == LSR || op == ROL || op == ROR; }

// The bodies of the handlers; a friend of the console.
struct Interpreter {
    // Runs until the frame ends, or until the instruction limit may be near (kLimit). If `labels` is not null it runs
    // nothing, and returns the handlers' labels, which exist only in this function.
    static Exit run(FastConsole* console, const void* const** labels = nullptr);

    // Runs up to `left` instructions one by one, or to the end of the frame.
    static void run_counted(FastConsole& c, int left);

    static const void* label(uint16_t handler);

    // The functions that translated code calls (translator.hpp). `step_of` returns a handler; for a superinstruction,
    // the handler of its first instruction. `skip_loop` skips rounds of the loop that begins at `r.at`.
    using Step = Exit (*)(Registers&, FastConsole&) noexcept;
    static Step step_of(uint16_t handler);
    static Exit skip_loop(Registers& r, FastConsole& c) noexcept;

  private:
    using R = Registers;
    static const Step kSteps[];

    // --- the program counter and jumps ---

    static uint16_t pc_of(const FastConsole& c, const DecodedInstruction* at) {
        return static_cast<uint16_t>(c.origin_ + (at - c.base_instruction_));
    }

    // Returns the decoded instruction at `pc`, or null if the plain interpreter must run it.
    INLINE static const DecodedInstruction* enter(FastConsole& c, uint32_t pc) {
        const uint32_t segment = pc >> 10 & 15;
        if (!(c.code_segments_ >> segment & 1)) return enter_ram(c, pc);
        const DecodedInstruction* base = c.first_instruction_ + c.slot_.segment[segment];
        const DecodedInstruction* instruction = base + (pc & 0x3ff);
        if (instruction->handler == kStep) return nullptr;
        c.origin_ = pc & 0xfc00;
        c.base_instruction_ = base;
        return instruction;
    }

    static const DecodedInstruction* enter_ram(FastConsole& c, uint32_t pc) {
        if (!is_ram(pc)) return nullptr;
        c.origin_ = pc & 0xff80;
        c.base_instruction_ = c.ram_code_;
        return c.ram_code_ + (pc & 0x7f);
    }

    // Decodes the code in RAM at `at` again if its bytes have changed. Returns the handler of the instruction.
    static uint16_t decode_ram(FastConsole& c, const DecodedInstruction* at);

    // Jumps to an address that is computed at run time. Every path of unlimited length passes here or through `branch`.
    INLINE static Exit jump(R& r, FastConsole& c, uint32_t pc, uint32_t cost) {
        const DecodedInstruction* target = enter(c, pc);
        if (!target) return kInterpret;
        r.at = target;
        r.cycles += cost;
        return r.cycles >= c.cycle_limit_ ? kLimit : kNext;
    }

    INLINE static Exit branch(R& r, const FastConsole& c, bool taken) {
        if (!taken) {
            r.cycles += 2;
            r.at += 2;
            return kNext;
        }
        r.cycles += r.at->taken;
        r.at += r.at->jump;
        return r.cycles >= c.cycle_limit_ ? kLimit : kNext;
    }

    // --- memory ---

    static bool is_ram(uint32_t address) { return (address & 0x1280) == 0x80; }

    // Reads an address that is neither RAM nor plain image. `bus` is the last byte on the data bus.
    [[gnu::noinline]] static uint32_t read_port(FastConsole& c, uint32_t cycles, uint32_t address, uint32_t bus) {
        if (is_input(c, address)) return input(c, cycles, address, bus);
        c.m_.cycles = cycles;
        if (is_latches(c, address)) return c.read_latches(address & 7) | (bus & 0x3f);
        c.m_.bus = static_cast<uint8_t>(bus);
        return c.read(static_cast<uint16_t>(address));
    }

    static bool is_input(const FastConsole& c, uint32_t address) {
        return (address & 0x1088) == 8 && c.deferred_ && !c.slot_.watches_tia;
    }

    static bool is_latches(const FastConsole& c, uint32_t address) {
        return (address & 0x1088) == 0 && c.deferred_ && !c.slot_.watches_tia;
    }

    // Reads INPT0 .. INPT5, or one of two addresses that no chip drives. In a deferred frame a read changes nothing,
    // because the pixels that the reference TIA would render before it follow from the log.
    INLINE static uint32_t input(const FastConsole& c, uint32_t cycles, uint32_t address, uint32_t bus) {
        return (cycles >= c.inputs_from_[address & 7] ? 0x80u : 0u) | (bus & 0x3f);
    }

    // Stores outside RAM. Returns true if the frame has ended or the window shows another bank.
    static bool write_port(FastConsole& c, uint32_t cycles, uint32_t address, uint32_t value);

    // Stores to a TIA register. Returns false and changes nothing if writes to that register cannot be logged here.
    static bool write_register(uint32_t& cycles, FastConsole& c, uint32_t reg, uint32_t value);

    // Sets `slow` if the address is neither RAM nor plain image; the window may then show another bank. Bits of
    // `address` above the sixteenth, which the sum of base and index may set, are ignored.
    INLINE static uint32_t read_any(R& r, FastConsole& c, uint32_t address, uint32_t bus, bool& slow) {
        const uint8_t* page = c.pages_[address >> 6 & 255];
        if (page) [[likely]]
            return page[address & 63];
        slow = true;
        return read_port(c, r.cycles, address & 0xffff, bus);
    }

    INLINE static Exit write_any(R& r, FastConsole& c, uint32_t address, uint32_t value) {
        if (is_ram(address)) {
            c.m_.riot.ram[address & 0x7f] = static_cast<uint8_t>(value);
            return kNext;
        }
        const bool leave = write_port(c, r.cycles, address, value);
        r.cycles = c.m_.cycles;  // a write to WSYNC waits
        return leave ? kLeave : kNext;
    }

    INLINE static uint32_t pointer(const FastConsole& c, uint32_t zero_page) {
        const uint8_t* low = c.m_.riot.ram + zero_page;
        return low[0] | uint32_t{low[1]} << 8;
    }

    static uint32_t page_crossed(uint32_t base, uint32_t index) { return ((base & 0xff) + index) >> 8; }

    // Returns the operand of a read. Adds the instruction's cycles first, because its accesses happen at their end.
    template <Operand operand>
    INLINE static Exit load(R& r, FastConsole& c, uint32_t& value, bool& slow) {
        const uint32_t given = r.at->operand;
        r.cycles += read_cost(operand);
        if constexpr (operand == Operand::Imm || operand == Operand::Fixed) {
            value = given & 0xff;
        } else if constexpr (operand == Operand::Ram || operand == Operand::RamA) {
            value = c.m_.riot.ram[given];
        } else if constexpr (operand == Operand::RamX || operand == Operand::RamY) {
            const uint32_t address = (given + (operand == Operand::RamX ? r.x : r.y)) & 0xff;
            slow = !(address & 0x80);
            value = slow ? read_port(c, r.cycles, address, given) : c.m_.riot.ram[address & 0x7f];
        } else if constexpr (operand == Operand::Timer) {
            value = timer(r, c);
        } else if constexpr (operand == Operand::Input) {
            value = input(c, r.cycles, given, given);
        } else if constexpr (operand == Operand::Dpc) {
            value = read_dpc(c.m_.cart, c.slot_.image, given & 0x3f, r.cycles);
        } else if constexpr (operand == Operand::RomX || operand == Operand::RomY) {
            const uint32_t index = operand == Operand::RomX ? r.x : r.y;
            r.cycles += page_crossed(given, index);
            value = c.bank_[given + index];
        } else if constexpr (operand == Operand::AnyX || operand == Operand::AnyY) {
            const uint32_t index = operand == Operand::AnyX ? r.x : r.y;
            r.cycles += page_crossed(given, index);
            value = read_any(r, c, given + index, given >> 8, slow);
        } else if constexpr (operand == Operand::IndY) {
            const uint32_t base = pointer(c, given);
            r.cycles += page_crossed(base, r.y);
            value = read_any(r, c, base + r.y, base >> 8, slow);
        } else if constexpr (operand == Operand::IndX) {
            const uint32_t place = (given + r.x) & 0xff;
            if (!pointer_in_ram(place)) return kInterpret;
            const uint32_t address = pointer(c, place & 0x7f);
            value = read_any(r, c, address, address >> 8, slow);
        } else {
            slow = true;
            value = read_port(c, r.cycles, given, operand == Operand::PortZ ? given : given >> 8);
        }
        return kNext;
    }

    INLINE static uint32_t timer(const R& r, FastConsole& c) {
        const Riot& riot = c.m_.riot;
        const uint32_t intervals = (r.cycles - 1 - static_cast<uint32_t>(riot.set_at)) >> riot.shift;
        if (intervals < riot.timer) return riot.timer - intervals - 1;
        return read_port(c, r.cycles, 0x284, 0);
    }

    // --- operations ---

    template <int op, Operand operand>
    INLINE static Exit read(R& r, FastConsole& c) {
        const uint32_t cycles = r.cycles;
        uint32_t o;
        bool slow = false;
        if (load<operand>(r, c, o, slow) == kInterpret) {
            r.cycles = cycles;
            return kInterpret;
        }
        r.at += length_of(operand);
        if constexpr (op == LDA) r.nz = r.a = o;
        if constexpr (op == LDX) r.nz = r.x = o;
        if constexpr (op == LDY) r.nz = r.y = o;
        if constexpr (op == AND) r.nz = r.a &= o;
        if constexpr (op == ORA) r.nz = r.a |= o;
        if constexpr (op == EOR) r.nz = r.a ^= o;
        if constexpr (op == BIT) {
            r.nz = (r.a & o) | (o & 0x80) << 1;
            c.overflow_ = o & 0x40;
        }
        if constexpr (op == CMP || op == CPX || op == CPY) {
            const uint32_t reg = op == CMP ? r.a : op == CPX ? r.x : r.y;
            r.carry = reg >= o;
            r.nz = (reg - o) & 0xff;
        }
        if constexpr (op == ADC || op == SBC) {
            // V is set if both terms differ in sign from the sum. SBC adds o ^ 0xff. If A's sign is not the sum's, the
            // sign of o ^ 0xff differs from the sum's exactly if o's differs from A's.
            uint32_t sum = op == ADC ? r.a + r.carry + o : r.a + r.carry + 0xff - o;
            c.overflow_ = (r.a ^ sum) & (op == ADC ? o ^ sum : r.a ^ o) & 0x80;
            if (c.m_.cpu.d) [[unlikely]]
                sum = decimal_sum<op>(c, r.a, r.carry, o);
            r.carry = sum >> 8;
            r.nz = r.a = sum & 0xff;
        }
        return slow && c.remapped_ ? kLeave : kNext;
    }

    // Returns a sum in decimal mode, computed as the plain interpreter does; bit 8 is the carry.
    template <int op>
    [[gnu::noinline]] static uint32_t decimal_sum(FastConsole& c, uint32_t a, uint32_t carry, uint32_t o) {
        Cpu& cpu = c.m_.cpu;
        cpu.a = static_cast<uint8_t>(a);
        cpu.c = carry != 0;
        op == ADC ? cpu.adc(static_cast<uint8_t>(o)) : cpu.sbc(static_cast<uint8_t>(o));
        c.overflow_ = cpu.v;
        return cpu.a | (cpu.c ? 0x100u : 0u);
    }

    // Appends a TIA write to the write log. There is always room: see `kLogSize`.
    INLINE static void append_write(uint32_t cycles, FastConsole& c, uint32_t reg, uint32_t value,
                                    uint16_t beside = 0) {
        *c.log_end_++ = {cycles, static_cast<uint8_t>(reg), static_cast<uint8_t>(value), beside};
    }

    template <int op, Operand operand>
    INLINE static Exit store(R& r, FastConsole& c) {
        const uint32_t value = op == STA ? r.a : op == STX ? r.x : r.y;
        const uint32_t given = r.at->operand;
        uint32_t address = given;
        constexpr bool ram = operand == Operand::Ram || operand == Operand::RamA;
        if constexpr (ram) {
            c.m_.riot.ram[given] = static_cast<uint8_t>(value);
        } else if constexpr (operand == Operand::RamX || operand == Operand::RamY) {
            address = (given + (operand == Operand::RamX ? r.x : r.y)) & 0xff;
        } else if constexpr (operand == Operand::AnyX || operand == Operand::AnyY) {
            address = (given + (operand == Operand::AnyX ? r.x : r.y)) & 0xffff;
        } else if constexpr (operand == Operand::IndY || operand == Operand::IndX) {
            const uint32_t place = operand == Operand::IndX ? (given + r.x) & 0xff : given | 0x80;
            if (operand == Operand::IndX && !pointer_in_ram(place)) return kInterpret;
            address = (pointer(c, place & 0x7f) + (operand == Operand::IndY ? r.y : 0)) & 0xffff;
        }
        r.cycles += store_cost(operand);
        r.at += length_of(operand);
        if constexpr (ram) return kNext;
        constexpr bool direct = operand >= Operand::Tia;
        if (direct && r.cycles < c.deadline_) [[likely]] {
            write_tia<operand>(r.cycles, c, given, value);
            return kNext;
        }
        return write_any(r, c, address, value);
    }

    // Stores to a TIA register that affects only the framebuffer. `TiaShadow` decides whether the log needs the write.
    // (tests: test_fast_equals_plain.py; the list of writes that change nothing is tia.md 11.3)
    template <Operand operand>
    INLINE static void write_tia(uint32_t& cycles, FastConsole& c, uint32_t reg, uint32_t value) {
        TiaShadow& shadow = c.shadow_;
        const auto byte = static_cast<uint8_t>(value);
        if constexpr (operand == Operand::Tia || operand == Operand::TiaA) {
            if (shadow.write_value(reg, byte)) append_write(cycles, c, reg, value);
        } else if constexpr (operand == Operand::Strobe) {
            shadow.reg[reg] = 1;
            append_write(cycles, c, reg, value);
        } else if constexpr (operand == Operand::Nusiz) {
            if (shadow.write_nusiz(reg, byte)) append_write(cycles, c, reg, value);
        } else if constexpr (operand == Operand::Motion) {
            if (shadow.write_motion(reg, byte)) append_write(cycles, c, reg, value);
        } else if constexpr (operand == Operand::Hmove) {
            if (shadow.still() && is_ordinary_hmove(cycles - c.first_cycle_)) append_write(cycles, c, STILL, 0);
            else c.log_hmove(cycles);
        } else if constexpr (operand == Operand::Ctrlpf) {
            uint8_t kind;
            if (shadow.write_ctrlpf(byte, cycles - c.first_cycle_, kind)) append_write(cycles, c, kind, value);
        } else if constexpr (operand == Operand::Grp0 || operand == Operand::Grp0A) {
            if (shadow.write_grp0(byte)) append_write(cycles, c, reg, value, shadow.beside_grp0());
        } else if constexpr (operand == Operand::Grp1 || operand == Operand::Grp1A) {
            if (shadow.write_grp1(byte)) append_write(cycles, c, reg, value, shadow.beside_grp1());
        } else if constexpr (operand == Operand::Sound) {
            c.m_.sound.write(static_cast<uint8_t>(reg), byte);
        } else if constexpr (operand == Operand::Hmclr) {
            shadow.clear_motions();
        } else if constexpr (operand == Operand::Cxclr) {
            c.log_cxclr(cycles);
        } else {
            cycles = line_start(c, cycles);
        }
    }

    // Returns the cycle to which WSYNC waits: the start of the next line, or the current cycle if a line starts there.
    // Before `deadline_` nothing overflows.
    INLINE static uint32_t line_start(const FastConsole& c, uint32_t cycles) {
        return c.first_cycle_ + (cycles - c.first_cycle_ + kCyclesPerLine - 1) / kCyclesPerLine * kCyclesPerLine;
    }

    template <int op, Operand operand>
    INLINE static Exit modify(R& r, FastConsole& c) {
        uint32_t address = 0;
        uint32_t o = r.a;
        if constexpr (operand == Operand::Ram) address = r.at->operand;
        if constexpr (operand == Operand::RamX) {
            address = (r.at->operand + r.x) & 0xff;
            if (!(address & 0x80)) return kInterpret;
            address &= 0x7f;
        }
        if constexpr (operand != Operand::Acc) o = c.m_.riot.ram[address];
        uint32_t result;
        if constexpr (op == ASL) result = o << 1;
        if constexpr (op == LSR) result = o >> 1;
        if constexpr (op == ROL) result = o << 1 | r.carry;
        if constexpr (op == ROR) result = o >> 1 | r.carry << 7;
        if constexpr (op == INC) result = o + 1;
        if constexpr (op == DEC) result = o - 1;
        if constexpr (op == ASL || op == ROL) r.carry = o >> 7;
        if constexpr (op == LSR || op == ROR) r.carry = o & 1;
        r.nz = result & 0xff;
        if constexpr (operand == Operand::Acc) r.a = r.nz;
        else c.m_.riot.ram[address] = static_cast<uint8_t>(result);
        r.cycles += modify_cost(operand);
        r.at += length_of(operand);
        return kNext;
    }

    // The stack pointer may also be in TIA space: several games push flags into its registers.
    INLINE static Exit push(R& r, FastConsole& c, uint32_t value) {
        const uint32_t sp = c.m_.cpu.sp--, reg = tia_register(sp);
        r.cycles += 3;
        r.at += 1;
        const bool direct = !(sp & 0x80) && r.cycles < c.deadline_ && !c.slot_.watches_tia;
        if (direct && kStoredIn[reg] == Operand::Tia) {
            write_tia<Operand::Tia>(r.cycles, c, reg, value);
            return kNext;
        }
        return write_any(r, c, 0x100 | sp, value);
    }

    // The byte at the stack pointer is read first, and stays on the bus. `bus` is the byte before it.
    INLINE static uint32_t pull(R& r, FastConsole& c, uint32_t bus) {
        const uint32_t sp = c.m_.cpu.sp++;
        r.cycles += 4;
        r.at += 1;
        if (sp - 0x80 < 0x7f) return c.m_.riot.ram[(sp + 1) & 0x7f];
        return pull_port(c, r.cycles, sp, bus);
    }

    // Pulls where the stack is in TIA space, or partly. Such addresses switch no cartridge's banks.
    [[gnu::noinline]] static uint32_t pull_port(FastConsole& c, uint32_t cycles, uint32_t sp, uint32_t bus) {
        const uint32_t next = (sp + 1) & 0xff;
        if (is_input(c, sp) && is_input(c, next)) return input(c, cycles, next, input(c, cycles, sp, bus));
        const uint32_t passed = read_port(c, cycles, 0x100 | sp, bus);
        return read_port(c, cycles, 0x100 | next, passed);
    }

    INLINE static uint32_t status(const R& r, const FastConsole& c) {
        return ((r.nz | r.nz >> 1) & 0x80) | (c.overflow_ ? 0x40u : 0u) | c.modes_ | ((r.nz & 0xff) ? 0u : 2u) |
               r.carry;
    }

    INLINE static void set_status(R& r, FastConsole& c, uint32_t value) {
        r.nz = (value & 0x80) << 1 | ((value & 2) ? 0u : 1u);
        c.overflow_ = value & 0x40;
        r.carry = value & 1;
        set_modes(c, (value & 8) != 0, (value & 4) != 0);
    }

    INLINE static void set_modes(FastConsole& c, bool d, bool i) {
        c.m_.cpu.d = d;
        c.m_.cpu.i = i;
        c.modes_ = static_cast<uint8_t>(0x30 | d << 3 | i << 2);
    }

    template <Operand operand>
    INLINE static Exit call(R& r, FastConsole& c) {
        Cpu& cpu = c.m_.cpu;
        if (cpu.sp < 0x81) return kInterpret;
        const uint16_t back = static_cast<uint16_t>(pc_of(c, r.at) + 2);
        const Exit exit = go_to<operand>(r, c, 6);
        if (exit == kInterpret) return kInterpret;
        c.m_.riot.ram[cpu.sp-- & 0x7f] = static_cast<uint8_t>(back >> 8);
        c.m_.riot.ram[cpu.sp-- & 0x7f] = static_cast<uint8_t>(back);
        return exit;
    }

    template <Operand operand>
    INLINE static Exit go_to(R& r, FastConsole& c, uint32_t cost) {
        const uint32_t target = r.at->operand;
        if constexpr (operand == Operand::Near) {
            if (((target ^ pc_of(c, r.at)) & 0xf000) == 0) {
                r.at += r.at->jump;
                r.cycles += cost;
                return r.cycles >= c.cycle_limit_ ? kLimit : kNext;
            }
        }
        return jump(r, c, target, cost);
    }

    INLINE static Exit return_from(R& r, FastConsole& c) {
        Cpu& cpu = c.m_.cpu;
        if (cpu.sp - 0x80u >= 0x7e) return kInterpret;
        const uint8_t* stack = c.m_.riot.ram + (cpu.sp & 0x7f);
        const uint32_t back = stack[1] | uint32_t{stack[2]} << 8;
        if (!c.pages_[back >> 6 & 255]) return kInterpret;  // the byte at `back` is read too
        const Exit exit = jump(r, c, (back + 1) & 0xffff, 6);
        if (exit != kInterpret) cpu.sp = static_cast<uint8_t>(cpu.sp + 2);
        return exit;
    }

    INLINE static Exit jump_indirect(R& r, FastConsole& c) {
        const uint32_t place = r.at->operand;
        if ((place & 0xff) == 0xff) return kInterpret;
        if (is_ram(place)) return jump(r, c, pointer(c, place & 0x7f), 5);
        if (!(place & 0x1000) || (place & 0xfff) - c.slot_.plain.from >= c.slot_.plain.size - 1) return kInterpret;
        const uint8_t* low = c.slot_.image + c.slot_.segment[place >> 10 & 15] + (place & 0x3ff);
        return jump(r, c, low[0] | uint32_t{low[1]} << 8, 5);
    }

    template <int op>
    INLINE static Exit implied(R& r, FastConsole& c) {
        Cpu& cpu = c.m_.cpu;
        if constexpr (op == PHA) return push(r, c, r.a);
        if constexpr (op == PHP) return push(r, c, status(r, c));
        if constexpr (op == PLA) {
            r.nz = r.a = pull(r, c, 0x68);
            return kNext;
        }
        if constexpr (op == PLP) {
            set_status(r, c, pull(r, c, 0x28));
            return kNext;
        }
        if constexpr (op == RTS) return return_from(r, c);
        if constexpr (op == TAX) r.nz = r.x = r.a;
        if constexpr (op == TAY) r.nz = r.y = r.a;
        if constexpr (op == TXA) r.nz = r.a = r.x;
        if constexpr (op == TYA) r.nz = r.a = r.y;
        if constexpr (op == TSX) r.nz = r.x = cpu.sp;
        if constexpr (op == TXS) cpu.sp = static_cast<uint8_t>(r.x);
        if constexpr (op == INX) r.nz = r.x = (r.x + 1) & 0xff;
        if constexpr (op == INY) r.nz = r.y = (r.y + 1) & 0xff;
        if constexpr (op == DEX) r.nz = r.x = (r.x - 1) & 0xff;
        if constexpr (op == DEY) r.nz = r.y = (r.y - 1) & 0xff;
        if constexpr (op == CLC) r.carry = 0;
        if constexpr (op == SEC) r.carry = 1;
        if constexpr (op == CLI) set_modes(c, cpu.d, false);
        if constexpr (op == SEI) set_modes(c, cpu.d, true);
        if constexpr (op == CLV) c.overflow_ = 0;
        if constexpr (op == CLD) set_modes(c, false, cpu.i);
        if constexpr (op == SED) set_modes(c, true, cpu.i);
        r.cycles += 2;
        r.at += 1;
        return kNext;
    }

    template <int op, Operand operand>
    INLINE static Exit run_one(R& r, FastConsole& c) {
        if constexpr (is_read(op)) return read<op, operand>(r, c);
        else if constexpr (is_store(op)) return store<op, operand>(r, c);
        else if constexpr (is_modify(op)) return modify<op, operand>(r, c);
        else if constexpr (op == BPL) return branch(r, c, !(r.nz & 0x180));
        else if constexpr (op == BMI) return branch(r, c, r.nz & 0x180);
        else if constexpr (op == BNE) return branch(r, c, r.nz & 0xff);
        else if constexpr (op == BEQ) return branch(r, c, !(r.nz & 0xff));
        else if constexpr (op == BCC) return branch(r, c, !r.carry);
        else if constexpr (op == BCS) return branch(r, c, r.carry);
        else if constexpr (op == BVC) return branch(r, c, !c.overflow_);
        else if constexpr (op == BVS) return branch(r, c, c.overflow_);
        else if constexpr (op == JMP && operand == Operand::Ind) return jump_indirect(r, c);
        else if constexpr (op == JMP) return go_to<operand>(r, c, 3);
        else if constexpr (op == JSR) return call<operand>(r, c);
        else return implied<op>(r, c);
    }

    template <int op, Operand operand>
    static Exit run_single(Registers& r, FastConsole& c) noexcept {
        return run_one<op, operand>(r, c);
    }

    // Defined in loops.hpp.
    static void skip_rounds(R& r, const FastConsole& c);
    static uint32_t rounds_of_count(uint32_t& counter, uint16_t branch);
    static uint32_t rounds_until_timer(const R& r, const FastConsole& c);
    static uint32_t rounds_until_expiry(const R& r, const FastConsole& c);
    static uint32_t rounds_before(const R& r, uint32_t passed, uint32_t end);

    static void take(R& r, FastConsole& c) {
        const Cpu& cpu = c.m_.cpu;
        r.cycles = c.m_.cycles;
        r.a = cpu.a;
        r.x = cpu.x;
        r.y = cpu.y;
        r.nz = (cpu.z ? 0u : 1u) | (cpu.n ? 0x100u : 0u);
        r.carry = cpu.c ? 1 : 0;
        c.overflow_ = cpu.v;
        c.modes_ = static_cast<uint8_t>(0x30 | cpu.d << 3 | cpu.i << 2);
    }

    static void give(const R& r, FastConsole& c) {
        Cpu& cpu = c.m_.cpu;
        c.m_.cycles = r.cycles;
        cpu.a = static_cast<uint8_t>(r.a);
        cpu.x = static_cast<uint8_t>(r.x);
        cpu.y = static_cast<uint8_t>(r.y);
        cpu.n = (r.nz & 0x180) != 0;
        cpu.z = (r.nz & 0xff) == 0;
        cpu.c = r.carry != 0;
        cpu.v = c.overflow_ != 0;
    }
};

}  // namespace atari
