// `_emulator.RewardFormula`: the compiled reward of a task, bound for atari.wrappers.ExpressionReward and for the lanes
// of vectors. atari/games/rewards.py compiles it.
#include "ale/programs/reward.hpp"

#include <memory>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "threads.hpp"

namespace atari {
namespace {

using Words = std::vector<int32_t>;
using Inputs = List<double>;
using Ram = List<const uint8_t>;

void make_formula(Shared<RewardFormula>* self, const Words& terms, const std::vector<int>& visibility,
                  const Words& words, const std::vector<double>& constants) {
    Program program(terms, static_cast<int>(visibility.size()), false);
    new (self)
        Shared<RewardFormula>{std::make_shared<const RewardFormula>(std::move(program), visibility, words, constants)};
}

void check(const RewardFormula& formula, const Inputs& inputs, const Ram& ram) {
    if (inputs.shape(0) != formula.inputs()) throw std::invalid_argument("there must be a number for each input");
    if (ram.shape(0) != 128) throw std::invalid_argument("ram must be of shape (128,)");
}

// The GIL is held: another thread cannot change the arrays meanwhile.
void begin(const Shared<RewardFormula>& formula, Inputs inputs, Ram ram, int lives) {
    check(*formula.value, inputs, ram);
    formula.value->begin(inputs.data(), ram.data(), lives);
}

double pay(const Shared<RewardFormula>& formula, Inputs inputs, Ram ram, int lives, double game_reward) {
    check(*formula.value, inputs, ram);
    return formula.value->pay(inputs.data(), ram.data(), lives, game_reward);
}

}  // namespace

void register_reward(nb::module_& m) {
    nb::class_<Shared<RewardFormula>>(
        m, "RewardFormula", "The reward of a task as an expression, compiled. Immutable; environments share it.")
        .def("__init__", &make_formula, "terms"_a, "visibility"_a, "words"_a, "constants"_a,
             "`terms` is the program of the terms, and `visibility` has for each the term with its visibility, or -1.\n"
             "`words` are the operations of the formula, each with its argument.")
        .def_prop_ro(
            "inputs", [](const Shared<RewardFormula>& formula) { return formula.value->inputs(); },
            "The number of inputs, which are the state between two steps.")
        .def("begin", &begin, nb::arg("inputs").noconvert(), "ram"_a, "lives"_a,
             nb::sig("def begin(self, inputs: " NDARRAY("float64") ", ram: " NDARRAY("uint8") ", lives: int) -> None"),
             "Set the inputs after a reset.")
        .def("pay", &pay, nb::arg("inputs").noconvert(), "ram"_a, "lives"_a, "game_reward"_a,
             nb::sig("def pay(self, inputs: " NDARRAY("float64") ", ram: " NDARRAY(
                 "uint8") ", lives: int, game_reward: float) -> float"),
             "The reward of a step; sets the inputs after it.");
}

}  // namespace atari
