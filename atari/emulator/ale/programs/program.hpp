// Game rules as small programs for a stack machine. atari/games/compiler.py compiles the expressions of a game
// definition to words: two words an instruction, operation and argument.
#pragma once

#include <cstdint>
#include <vector>

namespace atari {

// clang-format off
enum class Op : int32_t {
    kPush,        // argument
    kLoad,        // variable
    kStore,       // variable
    kRam,         // byte of RAM at the popped address
    kXram,        // byte of the cartridge's RAM
    kAdd, kSubtract, kMultiply, kDivide, kModulo, kAnd, kOr, kXor, kShiftLeft, kShiftRight,
    kEqual, kNotEqual, kLess, kLessEqual, kGreater, kGreaterEqual,
    kNegate, kInvert, kNot,
    kJump,        // to the instruction number of the argument
    kJumpIfZero,  // pops
    kJumpIfZeroElsePop, kJumpIfNotZeroElsePop,  // the two halves of `and` and `or`
    kBcd,         // value of the bytes at popped addresses, least significant first; argument: their number
    kSigned8,
    kCount,       // how many bytes lo..hi equal one of the values; argument: the number of popped lo, hi and values
    kSame, kPositiveSum, kNegativeSum,  // over bytes lo..hi
    kRandom,      // the next word of the generator
    kRandomBetween,  // a number within the popped low..high
    // Only in programs that select a mode:
    kPressSelect, // for the popped number of frames
    kSoftReset,
    kAct,         // action of the argument
    kFail,        // the mode cannot be reached
    kEnd,
};
// clang-format on
inline constexpr int32_t kOpCount = static_cast<int32_t>(Op::kEnd) + 1;

struct Instruction {
    Op op;
    int32_t argument;
};

inline constexpr int kMaxVariables = 64;
inline constexpr int kMaxStack = 32;

// A validated program: its jumps, variables and stack depth are in range, so that running it needs no checks.
class Program {
  public:
    // Validates `words`, in the format above. If not `may_act`, jumps backwards and operations that run the console are
    // errors. Throws std::invalid_argument if the program is invalid.
    Program(const std::vector<int32_t>& words, int variables, bool may_act);
    Program() : Program({static_cast<int32_t>(Op::kEnd), 0}, 0, false) {}

    const Instruction* begin() const { return instructions_.data(); }
    bool reads_ram() const;

  private:
    std::vector<Instruction> instructions_;
};

}  // namespace atari
