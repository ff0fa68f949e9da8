// An assembler of the x86-64 instructions that the JIT translator (translator.cpp) needs: instructions with two
// operands, and jumps. One operand may be in memory. A jump may be emitted before its target.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <stdexcept>
#include <vector>

namespace atari {

enum Reg : uint8_t { rax, rcx, rdx, rbx, rsp, rbp, rsi, rdi, r8, r9, r10, r11, r12, r13, r14, r15 };

// An operand in memory: [base + index * scale + displacement]. The stack pointer as index stands for none.
struct Mem {
    Reg base;
    int32_t displacement = 0;
    Reg index = rsp;
    uint8_t scale = 1;
};

// Arithmetic with two operands, by the number it has in opcodes.
enum class Alu : uint8_t { add, or_, adc, sbb, and_, sub, xor_, cmp };
enum class ShiftDirection : uint8_t { left = 4, right = 5 };
enum class If : uint8_t { overflow, not_overflow, below, not_below, zero, not_zero, not_above, above, sign, not_sign };

constexpr If opposite(If condition) { return static_cast<If>(static_cast<int>(condition) ^ 1); }

// A position in the code. Before it is bound, the jumps to it form a linked list: each holds the end of the previous
// jump in place of its distance.
struct JumpLabel {
    int32_t at = -1;
    int32_t last_jump = -1;
};

// A forward jump with a distance of one byte. `bind_short` sets its target.
struct ShortJump {
    std::size_t end;  // the end of the jump instruction
};

class Assembler {
  public:
    const std::vector<uint8_t>& bytes() const { return bytes_; }
    std::size_t size() const { return bytes_.size(); }

    // Operands have 32 bits unless the name says otherwise. A write of 32 bits to a register clears its upper half.
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
    void alu64(Alu what, Reg to, Mem with) { code({opcode(what, 3)}, to, with, true); }
    void alu64(Alu what, Reg to, Reg with) { code({opcode(what, 3)}, to, with, true); }
    void alu(Alu what, Reg to, int32_t with) {
        const bool small = with == static_cast<int8_t>(with);
        code({static_cast<uint8_t>(small ? 0x83 : 0x81)}, static_cast<Reg>(what), to);
        if (small) put(static_cast<uint8_t>(with));
        else put32(static_cast<uint32_t>(with));
    }
    void alu64(Alu what, Reg to, int32_t with) {
        code({0x81}, static_cast<Reg>(what), to, true);
        put32(static_cast<uint32_t>(with));
    }
    void alu64(Alu what, Mem to, int8_t with) {
        code({0x83}, static_cast<Reg>(what), to, true);
        put(static_cast<uint8_t>(with));
    }
    void alu8(Alu what, Reg to, Reg with) { code({opcode(what, 2)}, to, with, false, true); }
    void alu8(Alu what, Reg to, Mem with) { code({opcode(what, 2)}, to, with, false, true); }
    void alu8(Alu what, Mem to, Reg with) { code({opcode(what, 0)}, with, to, false, true); }
    void alu8(Alu what, Reg to, uint8_t with) {
        code({0x80}, static_cast<Reg>(what), to, false, true);
        put(with);
    }
    void alu8(Alu what, Mem to, uint8_t with) {
        code({0x80}, static_cast<Reg>(what), to);
        put(with);
    }
    void increment8(Reg reg) { code({0xfe}, rax, reg, false, true); }
    void decrement8(Reg reg) { code({0xfe}, rcx, reg, false, true); }
    void shift(ShiftDirection where, Reg reg, uint8_t by) {
        code({0xc1}, static_cast<Reg>(where), reg);
        put(by);
    }
    void shift64(ShiftDirection where, Reg reg, uint8_t by) {
        code({0xc1}, static_cast<Reg>(where), reg, true);
        put(by);
    }
    void shift_by_cl(ShiftDirection where, Reg reg) { code({0xd3}, static_cast<Reg>(where), reg); }
    void multiply(Reg to, Reg from, uint32_t by) {
        code({0x69}, to, from);
        put32(by);
    }
    void test(Reg reg, Reg with) { code({0x85}, with, reg); }
    void test64(Reg reg, Reg with) { code({0x85}, with, reg, true); }
    void test8(Reg reg, Reg with) { code({0x84}, with, reg, false, true); }
    void test(Reg reg, uint32_t with) {
        code({0xf7}, rax, reg);
        put32(with);
    }
    void test_bit(Reg reg, uint8_t bit) {  // into the carry
        code({0x0f, 0xba}, static_cast<Reg>(4), reg);
        put(bit);
    }
    void test_bit(Reg bits, Reg number) { code({0x0f, 0xa3}, number, bits); }
    void test_bit64(Reg bits, Reg number) { code({0x0f, 0xa3}, number, bits, true); }
    void set8(If condition, Mem memory) {
        code({0x0f, static_cast<uint8_t>(0x90 + static_cast<int>(condition))}, rax, memory);
    }
    void set(If condition, Reg reg) {
        code({0x0f, static_cast<uint8_t>(0x90 + static_cast<int>(condition))}, rax, reg, false, true);
    }

    void push(Reg reg) {
        prefix(false, rax, rax, reg);
        put(static_cast<uint8_t>(0x50 + (reg & 7)));
    }
    void pop(Reg reg) {
        prefix(false, rax, rax, reg);
        put(static_cast<uint8_t>(0x58 + (reg & 7)));
    }
    void add_to_stack(int8_t bytes) {
        for (const int byte : {0x48, 0x83, 0xc4}) put(static_cast<uint8_t>(byte));
        put(static_cast<uint8_t>(bytes));
    }
    void set_carry() { put(0xf9); }
    void ret() { put(0xc3); }
    void jump(Reg to) { code({0xff}, static_cast<Reg>(4), to); }
    void call(Reg to) { code({0xff}, static_cast<Reg>(2), to); }

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
    // Loads the address of a label.
    void address_of(Reg to, JumpLabel& label) {
        prefix(true, to, rax, rax);
        put(0x8d);
        put(static_cast<uint8_t>((to & 7) << 3 | 5));
        distance(label);
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
    static uint8_t opcode(Alu what, int form) { return static_cast<uint8_t>(static_cast<int>(what) << 3 | form); }

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
        const Reg index = mem.index == rsp ? rax : mem.index;
        prefix(wide, reg, index, mem.base, bytes && reg >= rsp);
        for (const uint8_t byte : opcode) put(byte);
        const bool small = mem.displacement == static_cast<int8_t>(mem.displacement);
        const bool indexed = mem.index != rsp || (mem.base & 7) == rsp;
        put(static_cast<uint8_t>((small ? 0x40 : 0x80) | (reg & 7) << 3 | (indexed ? 4 : mem.base & 7)));
        if (indexed) {
            const int scale = mem.scale == 8 ? 3 : mem.scale == 4 ? 2 : mem.scale == 2 ? 1 : 0;
            put(static_cast<uint8_t>(scale << 6 | (mem.index & 7) << 3 | (mem.base & 7)));
        }
        if (small) put(static_cast<uint8_t>(mem.displacement));
        else put32(static_cast<uint32_t>(mem.displacement));
    }

    std::vector<uint8_t> bytes_;
};

}  // namespace atari
