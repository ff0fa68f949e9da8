// `_emulator.Write`, a write to RAM: atari/cores/writes.py makes it from the rules that atari/games/interventions
// compiles.

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "ale/programs/writes.hpp"
#include "arrays.hpp"
#include "threads.hpp"

namespace atari {
namespace {

Program program(const std::vector<int32_t>& words) {
    return words.empty() ? Program() : Program(words, kWriteVariables, false);
}

Shared<Write> make_write(int index, int mask, bool every_frame, bool at_reset, const std::vector<int32_t>& frames,
                         bool once, bool paid, bool remembers, const std::vector<int32_t>& condition,
                         const std::vector<int32_t>& value, const std::vector<int32_t>& label,
                         const std::string& definition) {
    auto write = std::make_shared<Write>();
    if (mask < 0 || mask > 255) throw std::invalid_argument("a mask is within 0..255");
    write->definition = definition;
    write->index = index;
    write->mask = static_cast<uint8_t>(mask);
    write->every_frame = every_frame;
    write->at_reset = at_reset;
    write->frames = frames;
    write->once = once;
    write->paid = paid;
    write->remembers = remembers;
    write->conditional = !condition.empty();
    write->condition = program(condition);
    write->value = program(value);
    write->of_label = !label.empty();
    write->label = program(label);
    write->prepare();
    return {write};
}

}  // namespace

void register_writes(nb::module_& m) {
    nb::class_<Shared<Write>>(m, "Write", "A write to RAM, compiled. Immutable; emulators share it.")
        .def_prop_ro(
            "definition", [](const Shared<Write>& write) { return write.value->definition; },
            "The text that `make_write` was given.")
        .def_prop_ro(
            "label_values", [](const Shared<Write>& write) { return write.value->label_values; },
            "The value of the label for each byte; empty if it depends on other bytes, or there is no label.");
    m.attr("MOST_WRITES") = kMaxWrites;
    m.def("make_write", &make_write, nb::kw_only(), "index"_a, "mask"_a, "every_frame"_a, "at_reset"_a, "frames"_a,
          "once"_a, "paid"_a, "remembers"_a, "condition"_a, "value"_a, "label"_a, "definition"_a,
          "Check and assemble a write; raises ValueError if a program is not sound.");
}

}  // namespace atari
