// The assembler of x86-64 (assembler.hpp has the rules): instructions with two operands, of which one may be in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <stdexcept>
#include <vector>

#include "assembler.hpp"

namespace atari::x86 {

inline constexpr Reg rax{0}, rcx{1}, rdx{2}, rbx{3}, rsp{4}, rbp{5}, rsi{6}, rdi{7};
inline constexpr Reg r8{8}, r9{9}, r10{10}, r11{11}, r12{12}, r13{13}, r14{14}, r15{15};

class Assembler {
  public:
    explicit Assembler(bool = false) {}  // every jump to a label reaches all code

    const std::vector<uint8_t>& bytes() const { return bytes_; }
    std::size_t size() const { return bytes_.size(); }
    // Returns the position at which the next instruction begins, so that jumps may lead there.
    int32_t here() const { return static_cast<int32_t>(size()); }

    void move(Reg to, Reg from) { code({0x8b}, to, from); }
    void move(Reg to, uint32_t value) {
        prefix(false, rax, rax, to);
        put(static_cast<uint8_t>(0xb8 + (to & 7)));
        put32(value);
    }
    void load(Reg to, Mem from) { code({0x8b}, to, from); }
    void load64(Reg to, Mem from) { code({0x8b}, to, from, true); }
    void load16(Reg to, Mem from) { code({0x0f, 0xb7}, to, from); }
    void load8(Reg to, Mem from) { code({0x0f, 0xb6}, to, from); }
    void extend8(Reg to, Reg from) { code({0x0f, 0xb6}, to, from, false, true); }
    void store(Mem to, Reg from) { code({0x89}, from, to); }
    void store64(Mem to, Reg from) { code({0x89}, from, to, true); }
    void store16(Mem to, Reg from) {
        put(0x66);
        code({0x89}, from, to);
    }
    void store8(Mem to, Reg from) { code({0x88}, from, to, false, true); }
    void store8(Mem to, uint8_t value) {
        code({0xc6}, rax, to);
        put(value);
    }
    void store(Mem to, uint32_t value) {
        code({0xc7}, rax, to);
        put32(value);
    }
    // Two numbers of 32 bits that follow each other in memory.
    void load_two(Reg first, Reg second, Mem from) {
        load(first, from);
        load(second, after(from));
    }
    void store_two(Mem to, Reg first, Reg second) {
        store(to, first);
        store(after(to), second);
    }
    void address(Reg to, Mem of) { code({0x8d}, to, of); }
    void address64(Reg to, Mem of) { code({0x8d}, to, of, true); }
    void move64(Reg to, Reg from) { code({0x8b}, to, from, true); }
    void move64(Reg to, uint64_t value) {
        prefix(true, rax, rax, to);
        put(static_cast<uint8_t>(0xb8 + (to & 7)));
        for (int shift = 0; shift < 64; shift += 8) put(static_cast<uint8_t>(value >> shift));
    }

    void alu(Alu what, Reg to, Reg with) { code({opcode(what, 3)}, to, with); }
    void alu(Alu what, Reg to, Mem with) { code({opcode(what, 3)}, to, with); }
    void alu(Alu what, Reg to, int32_t with) { with_constant(static_cast<int>(what), to, with); }
    void alu64(Alu what, Reg to, Reg with) { code({opcode(what, 3)}, to, with, true); }
    void alu64(Alu what, Reg to, Mem with) { code({opcode(what, 3)}, to, with, true); }
    void alu8(Alu what, Reg to, Mem with) { code({opcode(what, 2)}, to, with, false, true); }
    void alu8(Alu what, Mem to, uint8_t with) { with_constant8(static_cast<int>(what), to, with); }
    void alu8(Alu what, Reg to, const Byte& with) { with_byte(static_cast<int>(what), to, with); }
    void increment8(Reg reg) { code({0xfe}, rax, reg, false, true); }
    void decrement8(Reg reg) { code({0xfe}, rcx, reg, false, true); }
    void load8(Reg to, const Byte& from) {
        if (from.constant) move(to, uint32_t{*from.constant});
        else if (from.memory) load8(to, *from.memory);
        else move(to, from.reg);
    }
    void shift(ShiftDirection where, Reg reg, uint8_t by) {
        code({0xc1}, Reg(where), reg);
        put(by);
    }
    void shift64(ShiftDirection where, Reg reg, uint8_t by) {
        code({0xc1}, Reg(where), reg, true);
        put(by);
    }
    // Shifts `value` to the right by the number in memory, which is below 32. Uses `free`.
    void shift_right_by(Reg value, Mem number, Reg free) {
        move(free, rcx);
        load8(rcx, number);
        code({0xd3}, Reg(ShiftDirection::right), value);
        move(rcx, free);
    }
    // Takes the `bits` bits of `from` from bit `first` on.
    void extract(Reg to, Reg from, uint8_t first, uint8_t bits) {
        move(to, from);
        shift(ShiftDirection::right, to, first);
        if (bits == 8) extend8(to, to);
        else alu(Alu::and_, to, (1 << bits) - 1);
    }
    void multiply(Reg to, Reg from, uint32_t by) {
        code({0x69}, to, from);
        put32(by);
    }

    void compare(Reg reg, Reg with) { code({opcode(kCmp, 3)}, reg, with); }
    void compare(Reg reg, Mem with) { code({opcode(kCmp, 3)}, reg, with); }
    void compare(Reg reg, int32_t with) { with_constant(kCmp, reg, with); }
    void compare64(Reg reg, int32_t with) {
        code({0x81}, Reg(kCmp), reg, true);
        put32(static_cast<uint32_t>(with));
    }
    void compare8(Reg reg, uint8_t with) { with_constant8(kCmp, reg, with); }
    void compare8(Mem memory, Reg with) { code({opcode(kCmp, 0)}, with, memory, false, true); }
    void compare8(Mem memory, uint8_t with) { with_constant8(kCmp, memory, with); }
    void test(Reg reg) { code({0x85}, reg, reg); }
    void test64(Reg reg) { code({0x85}, reg, reg, true); }
    void test64(Mem memory) {
        code({0x83}, Reg(kCmp), memory, true);
        put(0);
    }
    void test8(Reg reg) { code({0x84}, reg, reg, false, true); }
    void test(Reg reg, uint32_t with) {
        code({0xf7}, rax, reg);
        put32(with);
    }
    // Sets the condition bit_set or bit_clear.
    void test_bit(Reg bits, Reg number) { code({0x0f, 0xa3}, number, bits); }
    void test_bit64(Reg bits, Reg number) { code({0x0f, 0xa3}, number, bits, true); }
    // These three do arithmetic and set a condition: of the result; of the operands, as `compare` does; and of the
    // result, of 8 bits.
    void or_and_test(Reg to, Reg with) { alu(Alu::or_, to, with); }
    void subtract_and_compare(Reg to, Reg with) { alu(Alu::sub, to, with); }
    void add8_and_test(Reg to, uint8_t with) { with_constant8(static_cast<int>(Alu::add), to, with); }
    // Sets a register that holds 0 or 1, or whose upper bits do not matter, to 1 or 0.
    void set(If condition, Reg reg) { set(static_cast<int>(condition), reg); }
    // Adds 1 after `compare8`. Only `not_below` is possible.
    void increment_if_not_below(Reg reg) { with_constant(kSbb, reg, -1); }

    // The arithmetic of the 6502. `carry` holds 0 or 1. `overflow` becomes 0 or not.
    // Adds, with the carry unless it is known to be 0.
    void add_with_carry(Reg to, const Byte& with, Reg carry, Mem overflow, bool is_clear) {
        if (!is_clear) {
            code({0x0f, 0xba}, Reg{4}, carry);
            put(0);
        }
        with_byte(is_clear ? static_cast<int>(Alu::add) : kAdc, to, with);
        set(static_cast<int>(If::below), carry);
        set_overflow(overflow);
    }
    // Subtracts, with the borrow unless the carry is known to be 1. The host's carry is a borrow.
    void subtract_with_carry(Reg to, const Byte& with, Reg carry, Mem overflow, bool is_set) {
        if (!is_set) compare(carry, 1);
        with_byte(is_set ? static_cast<int>(Alu::sub) : kSbb, to, with);
        set(static_cast<int>(If::not_below), carry);
        set_overflow(overflow);
    }
    // Subtracts. The carry becomes 1 if there is no borrow.
    void subtract8(Reg to, const Byte& with, Reg carry) {
        with_byte(static_cast<int>(Alu::sub), to, with);
        set(static_cast<int>(If::not_below), carry);
    }
    // Adds the carry out of byte + with to a counter. Replaces the byte.
    void add_carry_of(Reg counter, Reg byte, Reg with) {
        code({opcode(static_cast<int>(Alu::add), 2)}, byte, with, false, true);
        with_constant(kAdc, counter, 0);
    }
    // Sets a register to 0x80 if `number` has reached a number of 64 bits, otherwise to 0.
    void set_bit_7_if_reached(Reg to, Reg number, Mem reached) {
        code({opcode(kCmp, 3)}, number, reached, true);
        code({opcode(kSbb, 3)}, to, to);
        alu(Alu::and_, to, -0x80);
        alu(Alu::add, to, 0x80);
    }
    // Sets a register to 1 if a byte is not 0, otherwise to 0.
    void set_if_not_zero(Reg to, Mem byte) {
        compare8(byte, uint8_t{1});
        code({opcode(kSbb, 3)}, to, to);
        alu(Alu::add, to, 1);
    }
    // Shifts to the left, and shifts a 1 in if the low byte of `of` is 0.
    void shift_in_if_zero8(Reg to, Reg of) {
        compare8(of, uint8_t{1});
        code({opcode(kAdc, 3)}, to, to);
    }
    // Appends 8 bytes to what ends at `end`: a number of 32 bits, a constant byte, a byte, and 0.
    void append(Reg end, Reg number, uint8_t constant, Reg byte) {
        store(Mem{end}, number);
        store(Mem{end, 4}, uint32_t{constant});
        store8(Mem{end, 5}, byte);
        address64(end, Mem{end, 8});
    }

    void push(Reg reg) {
        prefix(false, rax, rax, reg);
        put(static_cast<uint8_t>(0x50 + (reg & 7)));
    }
    void pop(Reg reg) {
        prefix(false, rax, rax, reg);
        put(static_cast<uint8_t>(0x58 + (reg & 7)));
    }
    // Keep a register for a while, which is on the stack meanwhile.
    void save(Reg reg) { push(reg); }
    void restore(Reg reg) { pop(reg); }
    void add_to_stack(int8_t bytes) {
        for (const int byte : {0x48, 0x83, 0xc4}) put(static_cast<uint8_t>(byte));
        put(static_cast<uint8_t>(bytes));
    }
    void set_carry() { put(0xf9); }
    void ret() { put(0xc3); }
    void jump(Reg to) { code({0xff}, Reg{4}, to); }
    void call(Reg to) { code({0xff}, Reg{2}, to); }

    void jump(JumpLabel& to) {
        put(0xe9);
        distance(to);
    }
    void jump(If condition, JumpLabel& to) {
        put(0x0f);
        put(static_cast<uint8_t>(0x80 + static_cast<int>(condition)));
        distance(to);
    }
    void call(JumpLabel& to) {
        put(0xe8);
        distance(to);
    }
    // Loads the address of the place that is `bytes` before the start of the code.
    void address_before(Reg to, int32_t bytes) {
        prefix(true, to, rax, rax);
        put(0x8d);
        put(static_cast<uint8_t>((to & 7) << 3 | 5));
        put32(static_cast<uint32_t>(-static_cast<int32_t>(size()) - 4 - bytes));
    }
    void bind(JumpLabel& label) { bind(label, static_cast<int32_t>(size())); }
    void bind(JumpLabel& label, int32_t at) {
        label.at = at;
        while (label.last_jump >= 0) {
            const int32_t jump = label.last_jump;
            std::memcpy(&label.last_jump, bytes_.data() + jump - 4, 4);
            patch(jump, label.at);
        }
    }

    // Emits a jump over at most `kShortReach` bytes. `bind_short` sets its target.
    static constexpr std::size_t kShortReach = 127;
    ShortJump jump_short(If condition) {
        put(static_cast<uint8_t>(0x70 + static_cast<int>(condition)));
        put(0);
        return {size()};
    }
    // Throws std::logic_error if the jump does not reach this place.
    void bind_short(ShortJump jump) {
        const std::size_t distance = size() - jump.end;
        if (distance > kShortReach) throw std::logic_error("a short jump leads too far");
        bytes_[jump.end - 1] = static_cast<uint8_t>(distance);
    }

  private:
    static Mem after(Mem number) { return {number.base, number.displacement + 4}; }

    // Arithmetic in opcodes, besides `Alu`.
    static constexpr int kAdc = 2, kSbb = 3, kCmp = 7;

    static uint8_t opcode(int what, int form) { return static_cast<uint8_t>(what << 3 | form); }
    static uint8_t opcode(Alu what, int form) { return opcode(static_cast<int>(what), form); }

    void with_constant(int what, Reg to, int32_t with) {
        const bool small = with == static_cast<int8_t>(with);
        code({static_cast<uint8_t>(small ? 0x83 : 0x81)}, Reg(what), to);
        if (small) put(static_cast<uint8_t>(with));
        else put32(static_cast<uint32_t>(with));
    }
    void with_constant8(int what, Reg to, uint8_t with) {
        code({0x80}, Reg(what), to, false, true);
        put(with);
    }
    void with_constant8(int what, Mem to, uint8_t with) {
        code({0x80}, Reg(what), to);
        put(with);
    }
    void with_byte(int what, Reg to, const Byte& with) {
        if (with.constant) with_constant8(what, to, *with.constant);
        else if (with.memory) code({opcode(what, 2)}, to, *with.memory, false, true);
        else code({opcode(what, 2)}, to, with.reg, false, true);
    }
    void set(int condition, Reg reg) { code({0x0f, static_cast<uint8_t>(0x90 + condition)}, rax, reg, false, true); }
    void set_overflow(Mem byte) { code({0x0f, 0x90}, rax, byte); }

    void put(uint8_t byte) { bytes_.push_back(byte); }
    void put32(uint32_t value) {
        for (int shift = 0; shift < 32; shift += 8) put(static_cast<uint8_t>(value >> shift));
    }
    void distance(JumpLabel& to) {
        put32(static_cast<uint32_t>(to.last_jump));
        const auto here = static_cast<int32_t>(size());
        if (to.at < 0) to.last_jump = here;
        else patch(here, to.at);
    }
    void patch(int32_t end, int32_t to) {
        const int32_t distance = to - end;
        std::memcpy(bytes_.data() + end - 4, &distance, 4);
    }

    // Emits a REX prefix if it is needed: for 64 bits, for one of the upper eight registers, or for the low byte of rsi
    // and rdi.
    void prefix(bool wide, Reg reg, Reg index, Reg base, bool always = false) {
        const int rex = 0x40 | wide << 3 | (reg >> 3) << 2 | (index >> 3) << 1 | base >> 3;
        if (rex != 0x40 || always) put(static_cast<uint8_t>(rex));
    }
    void code(std::initializer_list<uint8_t> opcode, Reg reg, Reg other, bool wide = false, bool bytes = false) {
        prefix(wide, reg, rax, other, bytes && (reg >= rsp || other >= rsp));
        for (const uint8_t byte : opcode) put(byte);
        put(static_cast<uint8_t>(0xc0 | (reg & 7) << 3 | (other & 7)));
    }
    void code(std::initializer_list<uint8_t> opcode, Reg reg, Mem mem, bool wide = false, bool bytes = false) {
        const Reg index = mem.index == kNoRegister ? rax : mem.index;
        prefix(wide, reg, index, mem.base, bytes && reg >= rsp);
        for (const uint8_t byte : opcode) put(byte);
        const bool small = mem.displacement == static_cast<int8_t>(mem.displacement);
        const bool indexed = mem.index != kNoRegister || (mem.base & 7) == rsp;
        put(static_cast<uint8_t>((small ? 0x40 : 0x80) | (reg & 7) << 3 | (indexed ? 4 : mem.base & 7)));
        if (indexed) {
            const int scale = mem.scale == 8 ? 3 : mem.scale == 4 ? 2 : mem.scale == 2 ? 1 : 0;
            put(static_cast<uint8_t>(scale << 6 | (mem.index == kNoRegister ? rsp : mem.index & 7) << 3 |
                                     (mem.base & 7)));
        }
        if (small) put(static_cast<uint8_t>(mem.displacement));
        else put32(static_cast<uint32_t>(mem.displacement));
    }

    std::vector<uint8_t> bytes_;
};

}  // namespace atari::x86
