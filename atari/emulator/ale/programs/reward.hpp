// `RewardFormula`: the reward of a task that has its own, an expression over the game's reward, lives and RAM after a
// step, and over their values before it. atari/games/rewards.py compiles it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "program.hpp"

namespace atari {

// The operations of a formula on float64, in postfix order. A formula has no jumps: both sides of a condition are
// computed. Results are limited to the finite values of float32, and a division by zero is 0, so that no NaN and no
// infinity exists. The bit operations cut fractions off, and take whole numbers up to 2^53.
// clang-format off
enum class FormulaOp : int32_t {
    kLoad,  // variable
    kAdd, kSubtract, kMultiply, kDivide, kFloorDivide, kModulo, kAnd, kOr, kXor, kShiftLeft, kShiftRight,
    kEqual, kNotEqual, kLess, kLessEqual, kGreater, kGreaterEqual,
    kMinimum, kMaximum,
    kBoth, kEither,  // `and` and `or`: one of the operands
    kNegate, kInvert, kNot, kAbsolute,
    kChoose,         // the second operand if the first is not 0, else the third
    kCount,
};
// clang-format on

// Immutable after construction. Its variables are the inputs after the step, the inputs before it, and constants. The
// first inputs are the game's reward, the lives, and the lives lost; the others are terms, numbers that depend on RAM.
class RewardFormula {
  public:
    static constexpr size_t kOwnInputs = 3;
    static constexpr size_t kMaxStack = 256;

    // Term t is the variable t of the program `terms`, whose addresses are 0x80..0xff or 0..127. `visibility[t]` is the
    // term that says whether term t is visible, or -1 if it always is. `words` are pairs of an operation and its
    // argument. Throws std::invalid_argument if the formula is invalid.
    RewardFormula(Program terms, std::vector<int> visibility, const std::vector<int32_t>& words,
                  std::vector<double> constants);

    // The number of inputs, which are the state between two steps.
    size_t inputs() const { return kOwnInputs + visibility_.size(); }
    // Sets the inputs after a reset.
    void begin(double* inputs, const uint8_t* ram, int lives) const;
    // Returns the reward of a step, and sets the inputs after it.
    double pay(double* inputs, const uint8_t* ram, int lives, double game_reward) const;

  private:
    struct Instruction {
        FormulaOp op;
        size_t variable;
    };

    void read_terms(double* terms, const uint8_t* ram) const;
    double evaluate(const double* variables) const;

    Program terms_;
    std::vector<int> visibility_;
    std::vector<Instruction> instructions_;
    std::vector<double> constants_;
};

}  // namespace atari
