// The vocabulary of the assemblers, of which there is one for each processor (target.hpp chooses): registers, operands
// in memory, conditions and labels.
//
// The JIT translator speaks to an assembler by meaning. An assembler has the same functions as the others; each emits
// what its processor does best. These rules hold for all:
// - Operands have 32 bits unless the name says otherwise. A write of 32 bits to a register clears its upper half.
// - Operands of 8 bits are registers whose other bits are 0; results are such registers too. `test8` and the functions
//   that say so take the low byte of any register.
// - Only the functions `compare...`, `test...`, and those whose comment says so, set a condition. A jump, `set` or
//   `increment_if` uses it; in between, only `move` of a constant may stand. No other function keeps a condition.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>

namespace atari {

enum Reg : uint8_t {};
inline constexpr Reg kNoRegister{0xff};

// An operand in memory: [base + index * scale + displacement].
struct Mem {
    Reg base;
    int32_t displacement = 0;
    Reg index = kNoRegister;
    uint8_t scale = 1;
};

// The origin of a byte: the first of these that is there.
struct Byte {
    std::optional<uint8_t> constant;
    std::optional<Mem> memory;
    Reg reg;
};

// Arithmetic with two operands. (The numbers are those in opcodes of x86-64.)
enum class Alu : uint8_t { add = 0, or_ = 1, and_ = 4, sub = 5, xor_ = 6 };
enum class ShiftDirection : uint8_t { left = 4, right = 5 };

// Conditions after a comparison of unsigned numbers, and after a test. (The numbers are those in opcodes of x86-64.)
enum class If : uint8_t {
    below = 2,
    not_below,
    zero,
    not_zero,
    not_above,
    above,
    sign,
    not_sign,
    bit_set = below,
    bit_clear = not_below
};

constexpr If opposite(If condition) { return static_cast<If>(static_cast<int>(condition) ^ 1); }

// A position in the code. Before it is bound, the jumps to it form a linked list, which begins at `last_jump`.
struct JumpLabel {
    int32_t at = -1;
    int32_t last_jump = -1;

    bool has_jumps() const { return last_jump >= 0; }
};

// A forward jump over few bytes. `bind_short` sets its target.
struct ShortJump {
    std::size_t end;  // the end of the jump instruction
};

// A jump does not reach its target. An assembler that was made with `far` emits jumps that do.
struct JumpTooFar : std::runtime_error {
    JumpTooFar() : std::runtime_error("a jump leads too far") {}
};

}  // namespace atari
