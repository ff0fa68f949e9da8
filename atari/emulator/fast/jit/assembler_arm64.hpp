// The assembler of arm64 (A64; assembler.hpp has the rules). Its instructions have three operands and a fixed length,
// and only loads and stores access memory. So operands in memory go through x16 and x17, which have no other use.
//
// Conditions are lazy. A comparison with 0 or of bits emits nothing: the jump after it does both in one or two
// instructions. A move into a register that the next instruction changes becomes part of that instruction.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <vector>

#include "assembler.hpp"

namespace atari::arm64 {

// A register by its number: x0 to x30, of which the lower halves are w0 to w30.
constexpr Reg numbered(int number) { return Reg(number); }
inline constexpr Reg kZeroRegister = numbered(31), kLink = numbered(30);

// Returns the 13 bits that stand in an instruction for a constant of 32 bits under a logical operation: a run of ones
// that is rotated, and repeated every 2, 4, 8, 16 or 32 bits. Returns nothing for other constants.
constexpr std::optional<uint32_t> logical_constant(uint32_t value) {
    for (int size = 2; size <= 32; size *= 2) {
        const uint32_t mask = size == 32 ? ~0u : (1u << size) - 1;
        const uint32_t element = value & mask;
        bool repeats = true;
        for (int at = 0; at < 32; at += size) repeats &= (value >> at & mask) == element;
        if (!repeats || element == 0 || element == mask) continue;
        for (int rotation = 0; rotation < size; ++rotation) {
            // The element, rotated to the left: a run of ones at the bottom if the rotation is right.
            const uint32_t run = rotation ? (element << rotation | element >> (size - rotation)) & mask : element;
            if (run & (run + 1)) continue;
            const auto ones = static_cast<uint32_t>(std::popcount(run));
            const uint32_t kind = size == 32 ? 0 : (~(2u * static_cast<uint32_t>(size) - 1) & 0x3f);
            return static_cast<uint32_t>(rotation) << 6 | kind | (ones - 1);
        }
        return {};
    }
    return {};
}

class Assembler {
  public:
    // A conditional jump reaches 1 MiB. If `far`, it is made of two jumps and reaches 128 MiB.
    explicit Assembler(bool far = false) : far_(far) {}

    const std::vector<uint8_t>& bytes() const { return bytes_; }
    std::size_t size() const { return bytes_.size(); }
    // Returns the position at which the next instruction begins, so that jumps may lead there.
    int32_t here() {
        moved_ = {};
        return static_cast<int32_t>(size());
    }

    void move(Reg to, Reg from) {
        put(kOr | from << 16 | kZeroRegister << 5 | to);
        moved_ = {size(), to, from};
    }
    void move(Reg to, uint32_t value) {
        if (value > 0xffff && (~value >> 16) == 0) return put(0x12800000 | (~value & 0xffff) << 5 | to);
        if (value > 0xffff && (~value & 0xffff) == 0) return put(0x12a00000 | (~value >> 16) << 5 | to);
        if (value & 0xffff || !value) {
            put(0x52800000 | (value & 0xffff) << 5 | to);
            if (value >> 16) put(0x72a00000 | (value >> 16) << 5 | to);
        } else {
            put(0x52a00000 | (value >> 16) << 5 | to);
        }
    }
    void move64(Reg to, Reg from) { put(kWide | kOr | from << 16 | kZeroRegister << 5 | to); }
    void move64(Reg to, uint64_t value) {
        put(0xd2800000 | static_cast<uint32_t>(value & 0xffff) << 5 | to);
        for (uint32_t part = 1; part < 4; ++part)
            if (const auto bits = static_cast<uint32_t>(value >> (16 * part) & 0xffff))
                put(0xf2800000 | part << 21 | bits << 5 | to);
    }
    void load(Reg to, Mem from) { access(kLoad, 2, to, from); }
    void load64(Reg to, Mem from) { access(kLoad, 3, to, from); }
    void load16(Reg to, Mem from) { access(kLoad, 1, to, from); }
    void load8(Reg to, Mem from) { access(kLoad, 0, to, from); }
    void load8(Reg to, const Byte& from) {
        if (from.constant) move(to, uint32_t{*from.constant});
        else if (from.memory) load8(to, *from.memory);
        else move(to, from.reg);
    }
    void extend8(Reg to, Reg from) { extract(to, from, 0, 8); }
    void store(Mem to, Reg from) { access(kStore, 2, from, to); }
    void store64(Mem to, Reg from) { access(kStore, 3, from, to); }
    void store16(Mem to, Reg from) { access(kStore, 1, from, to); }
    void store8(Mem to, Reg from) { access(kStore, 0, from, to); }
    void store8(Mem to, uint8_t value) { access(kStore, 0, in_register(value, kSecond), to); }
    void store(Mem to, uint32_t value) { access(kStore, 2, in_register(value, kSecond), to); }
    // Two numbers of 32 bits that follow each other in memory, at most 252 bytes after the base.
    void load_two(Reg first, Reg second, Mem from) { access_two(0x29400000, first, second, from); }
    void store_two(Mem to, Reg first, Reg second) { access_two(0x29000000, first, second, to); }
    void address(Reg to, Mem of) { sum(to, of, 0); }
    void address64(Reg to, Mem of) { sum(to, of, kWide); }
    // Loads the address of the place that is `bytes` before the start of the code.
    void address_before(Reg to, int32_t bytes) {
        const int32_t distance = -static_cast<int32_t>(size()) - bytes;
        if (distance < -(1 << 20)) throw JumpTooFar();
        put(0x10000000 | (distance & 3u) << 29 | (distance >> 2 & 0x7ffffu) << 5 | to);
    }

    void alu(Alu what, Reg to, Reg with) {
        const Reg from = moved_into(to);
        put(operation(what) | (with == to ? from : with) << 16 | from << 5 | to);
    }
    void alu(Alu what, Reg to, Mem with) {
        load(kFirst, with);
        put(operation(what) | kFirst << 16 | to << 5 | to);
    }
    void alu(Alu what, Reg to, int32_t with) { with_constant(what, to, moved_into(to), with); }
    void alu64(Alu what, Reg to, Reg with) { put(kWide | operation(what) | with << 16 | to << 5 | to); }
    void alu64(Alu what, Reg to, Mem with) {
        load64(kFirst, with);
        alu64(what, to, kFirst);
    }
    void alu8(Alu what, Reg to, Mem with) {
        load8(kFirst, with);
        put(operation(what) | kFirst << 16 | to << 5 | to);
    }
    void alu8(Alu what, Reg to, const Byte& with) {
        if (with.constant) with_constant(what, to, to, *with.constant);
        else if (with.memory) alu8(what, to, *with.memory);
        else alu(what, to, with.reg);
    }
    void alu8(Alu what, Mem to, uint8_t with) {
        load8(kFirst, to);
        with_constant(what, kFirst, kFirst, what == Alu::and_ ? with | ~0xff : with);
        store8(to, kFirst);
    }
    void increment8(Reg reg) {
        with_constant(Alu::add, reg, moved_into(reg), 1);
        extend8(reg, reg);
    }
    void decrement8(Reg reg) {
        with_constant(Alu::sub, reg, moved_into(reg), 1);
        extend8(reg, reg);
    }
    void shift(ShiftDirection where, Reg reg, uint8_t by) { shift(where, reg, moved_into(reg), by); }
    void shift64(ShiftDirection where, Reg reg, uint8_t by) {
        const uint32_t n = by;
        put(0xd3400000 | (where == ShiftDirection::right ? n << 16 | 63 << 10 : (64 - n) % 64 << 16 | (63 - n) << 10) |
            reg << 5 | reg);
    }
    // Shifts `value` to the right by the number in memory, which is below 32.
    void shift_right_by(Reg value, Mem number, Reg) {
        load8(kFirst, number);
        put(kShiftByRegister | kFirst << 16 | value << 5 | value);
    }
    // Takes the `bits` bits of `from` from bit `first` on.
    void extract(Reg to, Reg from, uint8_t first, uint8_t bits) {
        put(kBitField | first << 16 | (first + bits - 1u) << 10 | from << 5 | to);
    }
    void multiply(Reg to, Reg from, uint32_t by) {
        move(kFirst, by);
        put(0x1b007c00 | kFirst << 16 | from << 5 | to);
    }

    void compare(Reg reg, Reg with) {
        put(kSubtractAndCompare | with << 16 | reg << 5 | kZeroRegister);
        condition_ = {Condition::kFlags};
    }
    void compare(Reg reg, Mem with) {
        load(kFirst, with);
        compare(reg, kFirst);
    }
    void compare(Reg reg, int32_t with) {
        if (with < 0 || with > 0xfff) return compare(reg, in_register(static_cast<uint32_t>(with), kFirst));
        put(0x71000000 | static_cast<uint32_t>(with) << 10 | reg << 5 | kZeroRegister);
        condition_ = {Condition::kFlags};
    }
    void compare64(Reg reg, int32_t with) {
        put(kWide | kSubtractAndCompare | in_register(static_cast<uint32_t>(with), kFirst) << 16 | reg << 5 |
            kZeroRegister);
        condition_ = {Condition::kFlags};
    }
    // The register holds a byte.
    void compare8(Reg reg, uint8_t with) { compare(reg, int32_t{with}); }
    // The register's low byte counts, as on x86-64.
    void compare8(Mem memory, Reg with) {
        load8(kFirst, memory);
        put(kSubtractAndCompareByte | with << 16 | kFirst << 5 | kZeroRegister);
        condition_ = {Condition::kFlags};
    }
    void compare8(Mem memory, uint8_t with) {
        load8(kFirst, memory);
        if (with) compare(kFirst, int32_t{with});
        else test(kFirst);
    }
    void test(Reg reg) { condition_ = {Condition::kZero, reg, 0, size()}; }
    void test64(Reg reg) { condition_ = {Condition::kZero, reg, kWide, size()}; }
    void test64(Mem memory) {
        load64(kFirst, memory);
        test64(kFirst);
    }
    void test8(Reg reg) { condition_ = {Condition::kByte, reg, 0, size()}; }
    void test(Reg reg, uint32_t with) {
        if (const auto constant = logical_constant(with)) {
            put(0x72000000 | *constant << 10 | reg << 5 | kZeroRegister);
        } else {
            put(0x6a000000 | in_register(with, kFirst) << 16 | reg << 5 | kZeroRegister);
        }
        condition_ = {Condition::kFlags};
    }
    // Sets the condition bit_set or bit_clear.
    void test_bit(Reg bits, Reg number) { test_bit(bits, number, 0); }
    void test_bit64(Reg bits, Reg number) { test_bit(bits, number, kWide); }
    // These three do arithmetic and set a condition: of the result; of the operands, as `compare` does; and of the
    // result, of 8 bits.
    void or_and_test(Reg to, Reg with) {
        alu(Alu::or_, to, with);
        test(to);
    }
    void subtract_and_compare(Reg to, Reg with) {
        put(kSubtractAndCompare | with << 16 | to << 5 | to);
        condition_ = {Condition::kFlags};
    }
    void add8_and_test(Reg to, uint8_t with) {
        with_constant(Alu::add, to, moved_into(to), with);
        extend8(to, to);
        test8(to);
    }
    void set(If condition, Reg reg) {
        require_flags();
        put(kSet | opposite_code(condition) << 12 | reg);
    }
    // Adds 1 after `compare8`.
    void increment_if_not_below(Reg reg) {
        require_flags();
        put(0x1a800400 | reg << 16 | opposite_code(If::not_below) << 12 | reg << 5 | reg);
    }

    // The arithmetic of the 6502. `carry` holds 0 or 1. `overflow` becomes 0 or not. The bytes stand in the upper 8 bits,
    // so that the processor's own flags equal the flags of the 6502.
    // Adds, with the carry unless it is known to be 0.
    void add_with_carry(Reg to, const Byte& with, Reg carry, Mem overflow, bool is_clear) {
        if (is_clear) {
            const Reg byte = in_register(with, kFirst);
            shift(ShiftDirection::left, kSecond, to, 24);
            put(0x2b000000 | byte << 16 | 24 << 10 | kSecond << 5 | kSecond);
        } else {
            // The lower 24 bits are ones, so that the carry goes through them.
            if (with.constant) {
                move(kFirst, uint32_t{*with.constant} << 24 | 0xffffff);
            } else {
                invert(kFirst, in_register(with, kFirst), 0);
                invert(kFirst, kFirst, 24);
            }
            shift(ShiftDirection::left, kSecond, to, 24);
            compare(carry, 1);
            put(0x3a000000 | kFirst << 16 | kSecond << 5 | kSecond);
        }
        take_flags(to, carry, overflow);
    }
    // Subtracts, with the borrow unless the carry is known to be 1.
    void subtract_with_carry(Reg to, const Byte& with, Reg carry, Mem overflow, bool is_set) {
        const Reg byte = in_register(with, kFirst);
        if (is_set) {
            shift(ShiftDirection::left, kSecond, to, 24);
            put(kSubtractAndCompare | byte << 16 | 24 << 10 | kSecond << 5 | kSecond);
        } else {
            shift(ShiftDirection::left, kFirst, byte, 24);
            shift(ShiftDirection::left, kSecond, to, 24);
            compare(carry, 1);
            put(0x7a000000 | kFirst << 16 | kSecond << 5 | kSecond);
        }
        take_flags(to, carry, overflow);
    }
    // Subtracts. The carry becomes 1 if there is no borrow.
    void subtract8(Reg to, const Byte& with, Reg carry) {
        const Reg from = moved_into(to);
        if (with.constant) put(0x71000000 | *with.constant << 10 | from << 5 | to);
        else put(kSubtractAndCompare | in_register(with, kFirst) << 16 | from << 5 | to);
        condition_ = {Condition::kFlags};
        set(If::not_below, carry);
        extend8(to, to);
    }
    // Adds the carry out of byte + with to a counter. The byte may be the low one of a longer number.
    void add_carry_of(Reg counter, Reg byte, Reg with) {
        extend8(kFirst, byte);
        put(kAdd | with << 16 | kFirst << 5 | kFirst);
        put(kAdd | 1 << 22 | kFirst << 16 | 8 << 10 | counter << 5 | counter);
    }
    // Sets a register to 0x80 if `number` has reached a number of 64 bits, otherwise to 0.
    void set_bit_7_if_reached(Reg to, Reg number, Mem reached) {
        load64(kFirst, reached);
        put(kWide | kSubtractAndCompare | kFirst << 16 | number << 5 | kZeroRegister);
        condition_ = {Condition::kFlags};
        set(If::not_below, to);
        shift(ShiftDirection::left, to, to, 7);
    }
    // Sets a register to 1 if a byte is not 0, otherwise to 0.
    void set_if_not_zero(Reg to, Mem byte) {
        load8(kFirst, byte);
        compare(kFirst, 0);
        set(If::not_zero, to);
    }
    // Shifts to the left, and shifts a 1 in if the low byte of `of` is 0.
    void shift_in_if_zero8(Reg to, Reg of) {
        test(of, 0xff);
        set(If::zero, kFirst);
        put(kAdd | to << 16 | 1 << 10 | kFirst << 5 | to);
    }
    // Appends 8 bytes to what ends at `end`: a number of 32 bits, a constant byte, a byte, and 0.
    void append(Reg end, Reg number, uint8_t constant, Reg byte) {
        move(kFirst, uint32_t{constant});
        put(kOr | byte << 16 | 8 << 10 | kFirst << 5 | kFirst);
        put(0x28800000 | 2 << 15 | kFirst << 10 | end << 5 | number);
    }

    // Keep a register for a while.
    void save(Reg reg) { move64(kSaved, reg); }
    void restore(Reg reg) { move64(reg, kSaved); }
    // Pairs of registers on the stack, at 16 * `pair` bytes from its top.
    void store_pair(Reg first, Reg second, uint32_t pair) {
        put(0xa9000000 | 2 * pair << 15 | second << 10 | kStack << 5 | first);
    }
    void load_pair(Reg first, Reg second, uint32_t pair) {
        put(0xa9400000 | 2 * pair << 15 | second << 10 | kStack << 5 | first);
    }
    void add_to_stack(int32_t bytes) {
        const bool adds = bytes >= 0;
        put((adds ? 0x91000000 : 0xd1000000) | static_cast<uint32_t>(adds ? bytes : -bytes) << 10 | kStack << 5 |
            kStack);
    }
    void ret() { put(0xd65f0000 | kLink << 5); }
    void jump(Reg to) { put(0xd61f0000 | to << 5); }
    void call(Reg to) { put(0xd63f0000 | to << 5); }

    void jump(JumpLabel& to) { put_jump(kJump, to); }
    void call(JumpLabel& to) { put_jump(0x94000000, to); }
    void jump(If condition, JumpLabel& to) { put_jump(conditional(condition), to); }
    void bind(JumpLabel& label) { bind(label, here()); }
    void bind(JumpLabel& label, int32_t at) {
        label.at = at;
        while (label.last_jump >= 0) {
            const Jump jump = jumps_[static_cast<std::size_t>(label.last_jump)];
            patch(jump.at, label.at);
            label.last_jump = jump.previous;
        }
    }

    // Emits a jump over few bytes. `bind_short` sets its target.
    ShortJump jump_short(If condition) {
        if (condition_.what == Condition::kByte && (condition == If::sign || condition == If::not_sign)) {
            require_fresh();
            put((condition == If::sign ? kJumpIfBit : kJumpIfNoBit) | 7 << 19 | condition_.reg);
        } else {
            put(conditional(condition));
        }
        return {size()};
    }
    void bind_short(ShortJump jump) { patch(static_cast<int32_t>(jump.end) - 4, here()); }

  private:
    static constexpr Reg kFirst = numbered(16), kSecond = numbered(17), kSaved = numbered(15), kStack = numbered(31);
    static constexpr uint32_t kWide = 0x80000000, kAdd = 0x0b000000, kOr = 0x2a000000, kBitField = 0x53000000,
                              kSubtractAndCompare = 0x6b000000, kSubtractAndCompareByte = 0x6b200000,
                              kShiftByRegister = 0x1ac02400, kSet = 0x1a9f07e0, kLoad = 1 << 22, kStore = 0,
                              kJump = 0x14000000, kJumpIfBit = 0x37000000, kJumpIfNoBit = 0x36000000;

    // The last test or comparison, which the next jump uses.
    struct Condition {
        enum { kNone, kFlags, kZero, kByte, kBit } what = kNone;
        Reg reg = kNoRegister;
        uint32_t wide = 0;
        std::size_t at = 0;  // the end of the code then; nothing may come between, because the register may change
    };
    struct Move {
        std::size_t end = 0;
        Reg to = kNoRegister, from = kNoRegister;
    };
    struct Jump {
        int32_t at, previous;
    };

    void put(uint32_t instruction) {
        const std::size_t at = bytes_.size();
        bytes_.resize(at + 4);
        for (uint32_t i = 0; i < 4; ++i) bytes_[at + i] = static_cast<uint8_t>(instruction >> 8 * i);
    }

    // If the last instruction moves a register into `to`, removes it and returns that register, otherwise `to`. The
    // next instruction must write to `to`.
    Reg moved_into(Reg to) {
        if (moved_.end != size() || moved_.to != to) return to;
        bytes_.resize(size() - 4);
        moved_.end = 0;
        return moved_.from;
    }

    static uint32_t operation(Alu what) {
        switch (what) {
            case Alu::add: return kAdd;
            case Alu::or_: return kOr;
            case Alu::and_: return 0x0a000000;
            case Alu::sub: return 0x4b000000;
            default: return 0x4a000000;
        }
    }
    void with_constant(Alu what, Reg to, Reg from, int32_t with) {
        if (what == Alu::add || what == Alu::sub) return add_constant(to, from, what == Alu::add ? with : -with, 0);
        const auto value = static_cast<uint32_t>(with);
        const auto constant = logical_constant(value);
        if (!constant) return put(operation(what) | in_register(value, kSecond) << 16 | from << 5 | to);
        put((what == Alu::and_  ? 0x12000000
             : what == Alu::or_ ? 0x32000000
                                : 0x52000000) |
            *constant << 10 | from << 5 | to);
    }
    void add_constant(Reg to, Reg from, int32_t value, uint32_t wide) {
        const uint32_t opcode = wide | (value < 0 ? 0x51000000u : 0x11000000u);
        const auto size = static_cast<uint32_t>(value < 0 ? -int64_t{value} : value);
        if (size > 0xffffff) throw std::length_error("a constant of an addition has more than 24 bits");
        if (size >> 12) {
            put(opcode | 1 << 22 | (size >> 12) << 10 | from << 5 | to);
            from = to;
        }
        if (size & 0xfff || !(size >> 12)) put(opcode | (size & 0xfff) << 10 | from << 5 | to);
    }
    // Returns a register that holds a value, loaded into `free` if need be.
    Reg in_register(uint32_t value, Reg free) {
        if (!value) return kZeroRegister;
        move(free, value);
        return free;
    }
    Reg in_register(const Byte& byte, Reg free) {
        if (byte.constant) return in_register(uint32_t{*byte.constant}, free);
        if (!byte.memory) return byte.reg;
        load8(free, *byte.memory);
        return free;
    }
    void shift(ShiftDirection where, Reg to, Reg from, uint8_t by) {
        const uint32_t n = by;
        put(kBitField | (where == ShiftDirection::right ? n << 16 | 31 << 10 : (32 - n) % 32 << 16 | (31 - n) << 10) |
            from << 5 | to);
    }
    // The complement of a register shifted to the left.
    void invert(Reg to, Reg from, uint32_t by) { put(0x2a200000 | from << 16 | by << 10 | kZeroRegister << 5 | to); }
    // After arithmetic on bytes in the upper bits of kSecond.
    void take_flags(Reg to, Reg carry, Mem overflow) {
        condition_ = {Condition::kFlags};
        set(If::not_below, carry);
        put(kSet | 7 << 12 | kFirst);  // if there is an overflow
        store8(overflow, kFirst);
        shift(ShiftDirection::right, to, kSecond, 24);
    }

    // A load or store of 1 << `size` bytes. If the address does not fit into the instruction, uses kFirst, or kSecond if
    // kFirst is stored.
    void access(uint32_t what, uint32_t size, Reg reg, Mem memory) {
        const uint32_t opcode = size << 30 | 0x38000000 | what;
        const Reg free = reg == kFirst ? kSecond : kFirst;
        if (memory.index != kNoRegister) {
            const auto shift = static_cast<uint32_t>(std::countr_zero(memory.scale));
            if (!memory.displacement && (shift == 0 || shift == size))
                return put(opcode | 0x00206800 | memory.index << 16 | (shift ? 1 << 12 : 0) | memory.base << 5 | reg);
            put(kWide | kAdd | memory.index << 16 | shift << 10 | memory.base << 5 | free);
            memory = {free, memory.displacement};
        }
        const int32_t offset = memory.displacement, scaled = offset >> size;
        if (offset >= 0 && scaled << size == offset && scaled < 0x1000)
            return put(opcode | 1 << 24 | static_cast<uint32_t>(scaled) << 10 | memory.base << 5 | reg);
        if (offset >= -256 && offset < 256)
            return put(opcode | (static_cast<uint32_t>(offset) & 0x1ff) << 12 | memory.base << 5 | reg);
        add_constant(free, memory.base, offset, kWide);
        put(opcode | 1 << 24 | free << 5 | reg);
    }
    void access_two(uint32_t opcode, Reg first, Reg second, Mem memory) {
        const int32_t offset = memory.displacement;
        if (offset < 0 || offset > 252 || offset % 4 || memory.index != kNoRegister)
            throw std::logic_error("two numbers do not stand there");
        put(opcode | static_cast<uint32_t>(offset) / 4 << 15 | second << 10 | memory.base << 5 | first);
    }
    void sum(Reg to, Mem of, uint32_t wide) {
        Reg from = of.base;
        if (of.index != kNoRegister) {
            const auto shift = static_cast<uint32_t>(std::countr_zero(of.scale));
            put(wide | kAdd | of.index << 16 | shift << 10 | from << 5 | to);
            if (!of.displacement) return;
            from = to;
        }
        add_constant(to, from, of.displacement, wide);
    }

    // --- conditions and jumps ---

    static uint32_t code(If condition) {
        switch (condition) {
            case If::below: return 3;
            case If::not_below: return 2;
            case If::zero: return 0;
            case If::not_zero: return 1;
            case If::not_above: return 9;
            case If::above: return 8;
            default: throw std::logic_error("a comparison has no such condition");
        }
    }
    static bool is_unconditional(uint32_t jump) { return (jump & 0x7c000000) == kJump; }  // or a call
    static bool is_flag_jump(uint32_t jump) { return jump >> 24 == 0x54; }
    static uint32_t opposite_code(If condition) { return code(condition) ^ 1; }
    void require_flags() const {
        if (condition_.what != Condition::kFlags) throw std::logic_error("no comparison came before");
    }
    void require_fresh() const {
        if (condition_.at != size()) throw std::logic_error("an instruction stands between a test and its jump");
    }
    void test_bit(Reg bits, Reg number, uint32_t wide) {
        put(wide | kShiftByRegister | number << 16 | bits << 5 | kFirst);
        condition_ = {Condition::kBit, kFirst, 0, size()};
    }

    // Returns a conditional jump without its distance. Emits the instruction that must come before it, if any.
    uint32_t conditional(If condition) {
        const Condition before = condition_;
        if (before.what == Condition::kFlags) return 0x54000000 | code(condition);
        require_fresh();
        const bool zero = condition == If::zero, not_zero = condition == If::not_zero;
        if (before.what == Condition::kZero && (zero || not_zero))
            return before.wide | (zero ? 0x34000000 : 0x35000000) | before.reg;
        if (before.what == Condition::kByte && (zero || not_zero)) {
            test(before.reg, 0xff);
        } else if (before.what == Condition::kByte && (condition == If::sign || condition == If::not_sign)) {
            test(before.reg, 0x80);
            condition = condition == If::sign ? If::not_zero : If::zero;
        } else if (before.what == Condition::kBit && (condition == If::bit_set || condition == If::bit_clear)) {
            test(before.reg, 1);
            condition = condition == If::bit_set ? If::not_zero : If::zero;
        } else {
            throw std::logic_error("a test has no such condition");
        }
        return 0x54000000 | code(condition);
    }
    void put_jump(uint32_t instruction, JumpLabel& to) {
        if (far_ && !is_unconditional(instruction)) {
            put((instruction ^ (is_flag_jump(instruction) ? 1 : 1 << 24)) | 2 << 5);  // the opposite, over the next
            instruction = kJump;
        }
        const auto at = static_cast<int32_t>(size());
        put(instruction);
        if (to.at >= 0) return patch(at, to.at);
        jumps_.push_back({at, to.last_jump});
        to.last_jump = static_cast<int32_t>(jumps_.size()) - 1;
    }
    // Sets the target of the jump at a position.
    void patch(int32_t at, int32_t to) {
        uint32_t instruction;
        std::memcpy(&instruction, bytes_.data() + at, 4);
        const int32_t distance = (to - at) / 4;
        const bool always = is_unconditional(instruction);
        const bool of_bit = (instruction & 0x7e000000) == 0x36000000;
        const int bits = always ? 26 : of_bit ? 14 : 19;
        if (distance < -(1 << (bits - 1)) || distance >= 1 << (bits - 1)) throw JumpTooFar();
        const uint32_t field = static_cast<uint32_t>(distance) & ((1u << bits) - 1);
        instruction |= always ? field : field << 5;
        std::memcpy(bytes_.data() + at, &instruction, 4);
    }

    const bool far_;
    std::vector<uint8_t> bytes_;
    Condition condition_;
    Move moved_;
    std::vector<Jump> jumps_;  // to labels that are not bound yet
};

}  // namespace atari::arm64
