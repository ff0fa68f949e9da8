#include "reward.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "evaluate.hpp"

namespace atari {
namespace {

// The data that the terms read.
struct TermHost : PassiveHost {
    const uint8_t* ram;
    int32_t variables[kMaxVariables]{};

    uint8_t byte(int64_t address) const { return ram[address & 0x7f]; }
};

// Returns a finite number of float32's range. A forged state may contain NaN.
double limited(double value) {
    constexpr double kMost = std::numeric_limits<float>::max();
    return std::isnan(value) ? 0.0 : std::clamp(value, -kMost, kMost);
}

int64_t whole(double value) {
    constexpr double kMost = 9007199254740992.0;  // 2^53
    return static_cast<int64_t>(std::clamp(value, -kMost, kMost));
}

int shift(double value) { return static_cast<int>(whole(value) & 31); }

// The remainder has the sign of the divisor, as in Python.
double modulo(double a, double b) {
    const double rest = std::fmod(a, b);
    return rest != 0.0 && (rest < 0.0) != (b < 0.0) ? rest + b : rest;
}

// The quotient rounded down, as Python computes it. a - rest is a multiple of b but for the rounding of float64.
double floor_divide(double a, double b) {
    const double rest = std::fmod(a, b);
    double quotient = (a - rest) / b;
    if (rest != 0.0 && (rest < 0.0) != (b < 0.0)) quotient -= 1.0;
    const double below = std::floor(quotient);
    return quotient - below > 0.5 ? below + 1.0 : below;
}

double binary(FormulaOp op, double a, double b) {
    switch (op) {
        case FormulaOp::kAdd: return a + b;
        case FormulaOp::kSubtract: return a - b;
        case FormulaOp::kMultiply: return a * b;
        case FormulaOp::kDivide: return b == 0.0 ? 0.0 : a / b;
        case FormulaOp::kFloorDivide: return b == 0.0 ? 0.0 : floor_divide(a, b);
        case FormulaOp::kModulo: return b == 0.0 ? 0.0 : modulo(a, b);
        case FormulaOp::kAnd: return static_cast<double>(whole(a) & whole(b));
        case FormulaOp::kOr: return static_cast<double>(whole(a) | whole(b));
        case FormulaOp::kXor: return static_cast<double>(whole(a) ^ whole(b));
        case FormulaOp::kShiftLeft: return std::ldexp(static_cast<double>(whole(a)), shift(b));
        case FormulaOp::kShiftRight: return static_cast<double>(whole(a) >> shift(b));
        case FormulaOp::kEqual: return a == b;
        case FormulaOp::kNotEqual: return a != b;
        case FormulaOp::kLess: return a < b;
        case FormulaOp::kLessEqual: return a <= b;
        case FormulaOp::kGreater: return a > b;
        case FormulaOp::kGreaterEqual: return a >= b;
        case FormulaOp::kMinimum: return b < a ? b : a;
        case FormulaOp::kMaximum: return b > a ? b : a;
        case FormulaOp::kBoth: return a == 0.0 ? a : b;
        case FormulaOp::kEither: return a != 0.0 ? a : b;
        default: return 0.0;  // The constructor has found the others to be no binary operations.
    }
}

double unary(FormulaOp op, double a) {
    switch (op) {
        case FormulaOp::kNegate: return -a;
        case FormulaOp::kInvert: return static_cast<double>(~whole(a));
        case FormulaOp::kNot: return a == 0.0;
        default: return std::fabs(a);
    }
}

size_t operands(FormulaOp op) {
    if (op == FormulaOp::kLoad) return 0;
    if (op == FormulaOp::kChoose) return 3;
    return op >= FormulaOp::kNegate ? 1 : 2;
}

[[noreturn]] void refuse(const char* why) { throw std::invalid_argument(why); }

}  // namespace

RewardFormula::RewardFormula(Program terms, std::vector<int> visibility, const std::vector<int32_t>& words,
                             std::vector<double> constants)
    : terms_(std::move(terms)), visibility_(std::move(visibility)), constants_(std::move(constants)) {
    const auto count = static_cast<int>(visibility_.size());
    if (count > kMaxVariables) refuse("a reward has too many terms");
    for (const int term : visibility_)
        if (term < -1 || term >= count) refuse("the visibility of a term is no term");
    if (words.empty() || words.size() % 2 != 0 || words.size() > 20000)
        refuse("a formula has two words an instruction, and at most 10000 instructions");
    size_t depth = 0;
    for (size_t i = 0; i < words.size(); i += 2) {
        if (words[i] < 0 || words[i] >= static_cast<int32_t>(FormulaOp::kCount)) refuse("an operation is unknown");
        const Instruction instruction{static_cast<FormulaOp>(words[i]), static_cast<size_t>(words[i + 1])};
        if (words[i + 1] < 0 || instruction.variable >= 2 * inputs() + constants_.size())
            refuse("a formula names a variable that does not exist");
        if (depth < operands(instruction.op)) refuse("a formula needs more values than there are");
        depth = depth - operands(instruction.op) + 1;
        if (depth > kMaxStack) refuse("a formula needs too deep a stack");
        instructions_.push_back(instruction);
    }
    if (depth != 1) refuse("a formula has one result");
}

void RewardFormula::begin(double* inputs, const uint8_t* ram, int lives) const {
    inputs[0] = 0.0;
    inputs[1] = lives;
    inputs[2] = 0.0;
    read_terms(inputs + kOwnInputs, ram);
}

double RewardFormula::pay(double* inputs, const uint8_t* ram, int lives, double game_reward) const {
    const size_t count = this->inputs();
    std::vector<double> variables(2 * count + constants_.size());
    double* const now = variables.data();
    double* const before = now + count;
    std::transform(inputs, inputs + count, before, limited);
    std::copy(constants_.begin(), constants_.end(), before + count);
    inputs[0] = limited(game_reward);
    inputs[1] = lives;
    inputs[2] = std::max(before[1] - lives, 0.0);
    read_terms(inputs + kOwnInputs, ram);
    std::copy_n(inputs, count, now);
    // A term that is not visible has no value of its own: that of the other time stands for it, or 0.
    for (size_t term = 0; term < visibility_.size(); ++term) {
        if (visibility_[term] < 0) continue;
        const size_t at = kOwnInputs + term, shown = kOwnInputs + static_cast<size_t>(visibility_[term]);
        const bool is = inputs[shown] != 0.0, was = before[shown] != 0.0;
        if (!was) before[at] = is ? now[at] : 0.0;
        if (!is) now[at] = before[at];
    }
    return evaluate(variables.data());
}

void RewardFormula::read_terms(double* terms, const uint8_t* ram) const {
    TermHost host{{}, ram};
    atari::evaluate(terms_, host);
    std::copy_n(host.variables, visibility_.size(), terms);
}

double RewardFormula::evaluate(const double* variables) const {
    double stack[kMaxStack];
    double* top = stack;  // one past the last value
    for (const auto [op, variable] : instructions_) {
        double result;
        switch (operands(op)) {
            case 0: result = variables[variable]; break;
            case 1: result = unary(op, top[-1]); break;
            case 2: result = binary(op, top[-2], top[-1]); break;
            default: result = top[-3] != 0.0 ? top[-2] : top[-1]; break;
        }
        top -= operands(op);
        *top++ = limited(result);
    }
    return stack[0] + 0.0;  // no negative zero
}

}  // namespace atari
