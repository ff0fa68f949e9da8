#include "program.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace atari {
namespace {

// Returns the number of values that an instruction pops, and the number that it pushes.
// clang-format off
std::pair<int, int> stack_effect(const Instruction& instruction) {
    switch (instruction.op) {
        case Op::kPush: case Op::kLoad: case Op::kRandom: return {0, 1};
        case Op::kStore: case Op::kJumpIfZero: case Op::kJumpIfZeroElsePop: case Op::kJumpIfNotZeroElsePop:
        case Op::kPressSelect: return {1, 0};
        case Op::kRam: case Op::kXram: case Op::kNegate: case Op::kInvert: case Op::kNot: case Op::kSigned8:
            return {1, 1};
        case Op::kBcd: case Op::kCount: return {instruction.argument, 1};
        case Op::kJump: case Op::kSoftReset: case Op::kAct: case Op::kFail: case Op::kEnd: return {0, 0};
        default: return {2, 1};
    }
}
// clang-format on

bool jumps(Op op) {
    return op == Op::kJump || op == Op::kJumpIfZero || op == Op::kJumpIfZeroElsePop || op == Op::kJumpIfNotZeroElsePop;
}

[[noreturn]] void refuse(size_t at, const char* why) {
    throw std::invalid_argument("instruction " + std::to_string(at) + " of a rule program " + why);
}

void check(const Instruction& instruction, size_t at, size_t count, int variables, bool may_act) {
    const int32_t op = static_cast<int32_t>(instruction.op), argument = instruction.argument;
    if (op < 0 || op >= kOpCount) refuse(at, "is unknown");
    const bool acting = instruction.op >= Op::kPressSelect && instruction.op <= Op::kFail;
    if (acting && !may_act) refuse(at, "acts, which only the selection of a mode may");
    if ((instruction.op == Op::kLoad || instruction.op == Op::kStore) && (argument < 0 || argument >= variables))
        refuse(at, "names a variable that does not exist");
    if (instruction.op == Op::kBcd && (argument < 1 || argument > 8)) refuse(at, "has a wrong number of operands");
    if (instruction.op == Op::kCount && (argument < 3 || argument > 16)) refuse(at, "has a wrong number of operands");
    if (instruction.op == Op::kAct && (argument < 0 || argument > 17)) refuse(at, "has no action of a player");
    if (jumps(instruction.op)) {
        if (argument < 0 || static_cast<size_t>(argument) >= count) refuse(at, "jumps out of the program");
        const bool loops = may_act && instruction.op == Op::kJump;  // Environment::spend limits them at run time
        if (!loops && static_cast<size_t>(argument) <= at) refuse(at, "jumps backwards");
    }
}

}  // namespace

Program::Program(const std::vector<int32_t>& words, int variables, bool may_act) {
    if (words.empty() || words.size() % 2 != 0 || words.size() > 20000)
        throw std::invalid_argument("a rule program has two words an instruction, and at most 10000 instructions");
    if (variables < 0 || variables > kMaxVariables)
        throw std::invalid_argument("a rule program has at most " + std::to_string(kMaxVariables) + " variables");
    for (size_t i = 0; i < words.size(); i += 2) instructions_.push_back({static_cast<Op>(words[i]), words[i + 1]});
    if (instructions_.back().op != Op::kEnd) refuse(instructions_.size() - 1, "should be the end");

    // Stack depth before each instruction; -1 if not reached yet. All paths to an instruction must have equal depths.
    std::vector<int> depth(instructions_.size(), -1);
    std::vector<size_t> pending;
    const auto reach = [&](size_t at, int with) {
        if (depth[at] == -1) {
            depth[at] = with;
            pending.push_back(at);
        } else if (depth[at] != with) {
            refuse(at, "is reached with different stacks");
        }
    };
    for (size_t at = 0; at < instructions_.size(); ++at)
        check(instructions_[at], at, instructions_.size(), variables, may_act);
    reach(0, 0);
    while (!pending.empty()) {
        const size_t at = pending.back();
        pending.pop_back();
        const Instruction& instruction = instructions_[at];
        const auto [pops, pushes] = stack_effect(instruction);
        if (depth[at] < pops) refuse(at, "needs more values than there are");
        const int after = depth[at] - pops + pushes;
        if (after > kMaxStack) refuse(at, "needs too deep a stack");
        const bool keeps = instruction.op == Op::kJumpIfZeroElsePop || instruction.op == Op::kJumpIfNotZeroElsePop;
        if (jumps(instruction.op)) reach(static_cast<size_t>(instruction.argument), keeps ? depth[at] : after);
        const bool goes_on = instruction.op != Op::kJump && instruction.op != Op::kEnd && instruction.op != Op::kFail;
        if (goes_on) reach(at + 1, after);
    }
}

bool Program::reads_ram() const {
    return std::any_of(instructions_.begin(), instructions_.end(), [](const Instruction& instruction) {
        const Op op = instruction.op;
        return op == Op::kRam || op == Op::kXram || op == Op::kBcd || (op >= Op::kCount && op <= Op::kNegativeSum);
    });
}

}  // namespace atari
