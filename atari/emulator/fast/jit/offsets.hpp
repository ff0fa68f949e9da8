// Byte offsets of the fields that translated code uses, from the start of the console, of the registers and of a write
// log entry. The assertions here cover all assumptions of translated code about sizes and values.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fast/interpreter/handlers.hpp"
#include "target.hpp"

namespace atari {

// Only GCC and Clang build the translator, and both define offsetof for structs like these.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winvalid-offsetof"

struct Offsets {
    // A field of `size` bytes, which is the width of the accesses of translated code. ELEMENTS is an array of such
    // fields.
#define OFFSET(name, type, member, size)                                                     \
    static constexpr int32_t name() { return static_cast<int32_t>(offsetof(type, member)); } \
    static_assert(!kTranslates || sizeof(type::member) == (size), "translated code accesses it by as many bytes");
#define ELEMENTS(name, type, member, size, count) \
    OFFSET(name, type, member, (size) * (count))  \
    static_assert(!kTranslates || sizeof(type::member[0]) == (size), "translated code indexes it by as many bytes");

    OFFSET(at, Registers, at, 8)
    OFFSET(cycles, Registers, cycles, 4)
    OFFSET(a, Registers, a, 4)
    OFFSET(x, Registers, x, 4)
    OFFSET(y, Registers, y, 4)
    OFFSET(nz, Registers, nz, 4)
    OFFSET(carry, Registers, carry, 4)

    ELEMENTS(ram, FastConsole, m_.riot.ram, 1, 128)
    OFFSET(sp, FastConsole, m_.cpu.sp, 1)
    OFFSET(decimal, FastConsole, m_.cpu.d, 1)
    OFFSET(overflow, FastConsole, overflow_, 1)
    OFFSET(modes, FastConsole, modes_, 1)
    OFFSET(sound, FastConsole, m_.sound, 12)
    ELEMENTS(inputs, FastConsole, inputs_from_, 8, 8)
    OFFSET(timer, FastConsole, m_.riot.timer, 1)
    OFFSET(timer_shift, FastConsole, m_.riot.shift, 1)
    OFFSET(timer_set_at, FastConsole, m_.riot.set_at, 4)
    static constexpr int32_t kDeadlines = FastConsole::kDeadlines;
    ELEMENTS(deadlines, FastConsole, deadlines_, 4, kDeadlines)
    OFFSET(cycle_limit, FastConsole, cycle_limit_, 4)
    OFFSET(first_cycle, FastConsole, first_cycle_, 4)
    OFFSET(log_end, FastConsole, log_end_, 8)
    OFFSET(first_instruction, FastConsole, first_instruction_, 8)
    OFFSET(base_instruction, FastConsole, base_instruction_, 8)
    OFFSET(origin, FastConsole, origin_, 4)
    OFFSET(code_segments, FastConsole, code_segments_, 4)
    ELEMENTS(segments, FastConsole, slot_.segment, 4, 16)
    OFFSET(bank, FastConsole, bank_, 8)
    ELEMENTS(pages, FastConsole, pages_, 8, 256)
    ELEMENTS(shadow, FastConsole, shadow_.reg, 1, 64)
    OFFSET(old_grp0, FastConsole, shadow_.old_grp0, 1)
    OFFSET(old_grp1, FastConsole, shadow_.old_grp1, 1)
    OFFSET(old_enabl, FastConsole, shadow_.old_enabl, 1)
    OFFSET(late_reflect, FastConsole, shadow_.late_reflect, 1)
    OFFSET(ark, FastConsole, shadow_.ark, 1)
    OFFSET(watches_tia, FastConsole, slot_.watches_tia, 1)
    OFFSET(image, FastConsole, slot_.image, 8)
    OFFSET(dpc_random, FastConsole, m_.cart.random, 1)
    ELEMENTS(dpc_top, FastConsole, m_.cart.top, 1, 8)
    ELEMENTS(dpc_bottom, FastConsole, m_.cart.bottom, 1, 8)
    ELEMENTS(dpc_flag, FastConsole, m_.cart.flag, 1, 8)
    ELEMENTS(dpc_counter, FastConsole, m_.cart.counter, 2, 8)

    // A decoded instruction, and an entry of the write log.
    OFFSET(instruction_operand, DecodedInstruction, operand, 2)
    OFFSET(write_cycle, TiaWrite, cycle, 4)
    OFFSET(write_reg, TiaWrite, reg, 1)
    OFFSET(write_value, TiaWrite, value, 1)
    OFFSET(write_beside, TiaWrite, beside, 2)
#undef ELEMENTS
#undef OFFSET

    // The sound registers from AUDC0 on, in the order of their addresses.
    static_assert(offsetof(Sound, audc) == 0 && offsetof(Sound, audf) == AUDF0 - AUDC0 &&
                  offsetof(Sound, audv) == AUDV0 - AUDC0);
    static_assert(sizeof(Sound::audc[0]) == 1 && AUDC1 == AUDC0 + 1 && AUDF1 == AUDF0 + 1 && AUDV1 == AUDV0 + 1);
};

#pragma GCC diagnostic pop

// The size of a decoded instruction as a shift, which turns its index into an offset.
inline constexpr uint8_t kInstructionShift = 4;
static_assert(!kTranslates || sizeof(DecodedInstruction) == std::size_t{1} << kInstructionShift);

// An entry of the table at the start of translated code: the offset of an instruction's entry.
using TableEntry = int32_t;
inline constexpr uint8_t kTableShift = 2;
static_assert(sizeof(TableEntry) == std::size_t{1} << kTableShift && kTableShift <= kInstructionShift);

// The assembler's `append` appends an entry: the cycle, the register, the value, and 0 for `beside`.
inline constexpr int32_t kWriteSize = 8;
static_assert(sizeof(TiaWrite) == kWriteSize);
static_assert(Offsets::write_cycle() == 0 && Offsets::write_reg() == 4);
static_assert(Offsets::write_value() == Offsets::write_reg() + 1 &&
              Offsets::write_beside() == Offsets::write_reg() + 2);

// HMOVE reads the motions of players and missiles as one number of 32 bits, and the ball's separately.
static_assert(HMP1 == HMP0 + 1 && HMM0 == HMP0 + 2 && HMM1 == HMP0 + 3 && HMBL == HMP0 + 4);
static_assert(RESP1 - NUSIZ1 == RESP0 - NUSIZ0);

// Translated code saves and loads these in pairs.
static_assert(Offsets::a() == Offsets::cycles() + 4 && Offsets::y() == Offsets::x() + 4 &&
              Offsets::carry() == Offsets::nz() + 4);

// Translated code compares the result of a handler with 0, as a number of 32 bits.
static_assert(kNext == 0 && sizeof(Exit) == 4);
// Translated code stores 0 and 1 in flags, and reads flags as bytes.
static_assert(sizeof(bool) == 1 && sizeof(Flag) == 1);

}  // namespace atari
