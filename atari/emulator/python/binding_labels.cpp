// `_emulator.Labels`: names of RAM bytes, bound for atari/lab, which compiles their expressions.

#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "ale/programs/labels.hpp"
#include "arrays.hpp"
#include "threads.hpp"

namespace atari {
namespace {

using Ram = List<const uint8_t>;
using Words = std::vector<int32_t>;
using Parts = std::tuple<int, int, bool, Words, Words>;

void make_labels(Shared<Labels>* self, const std::vector<Parts>& parts) {
    std::vector<Label> labels;
    for (const auto& [index, mask, decimal, value, visible] : parts) {
        Label label{index, mask, decimal, Program(value, Label::kVariables, false), {}};
        if ((label.hides = !visible.empty())) label.visible = Program(visible, Label::kVariables, false);
        labels.push_back(label);
    }
    new (self) Shared<Labels>{std::make_shared<const Labels>(std::move(labels))};
}

// The GIL is held: another thread cannot change the arrays meanwhile.
void evaluate(const Shared<Labels>& labels, Table<const uint8_t> ram, Table<int32_t> values, Table<bool> visible) {
    const size_t count = labels.value->size(), rows = ram.shape(0);
    if (ram.shape(1) != kRamSize) throw std::invalid_argument("ram must be of shape (rows, 128)");
    if (values.shape(0) != count || values.shape(1) != rows || visible.shape(0) != count || visible.shape(1) != rows)
        throw std::invalid_argument("values and visible must be of shape (labels, rows)");
    labels.value->evaluate(ram.data(), rows, values.data(), reinterpret_cast<uint8_t*>(visible.data()));
}

void check(const Shared<Labels>& labels, int label, const Ram& ram) {
    if (label < 0 || static_cast<size_t>(label) >= labels.value->size())
        throw std::out_of_range("there is no label " + std::to_string(label));
    if (ram.shape(0) != kRamSize) throw std::invalid_argument("ram must be of shape (128,)");
}

std::vector<int32_t> possible_values(const Shared<Labels>& labels, int label, Ram ram) {
    check(labels, label, ram);
    int32_t values[256];
    bool writable[256];
    labels.value->all_values(static_cast<size_t>(label), ram.data(), values, writable);
    std::set<int32_t> possible;
    for (int byte = 0; byte < 256; ++byte)
        if (writable[byte]) possible.insert(values[byte]);
    return {possible.begin(), possible.end()};
}

}  // namespace

void register_labels(nb::module_& m) {
    nb::class_<Shared<Labels>>(m, "Labels", "Labels of RAM bytes, compiled. Use it through atari.lab.")
        .def("__init__", &make_labels, "labels"_a,
             "`labels` are tuples: index 0..127, mask 0..255, whether the byte is binary-coded decimal, and the\n"
             "programs for the value and the visibility, which may be empty. Variable 0 is the byte, variable 1 the\n"
             "result.")
        .def("__len__", [](const Shared<Labels>& labels) { return labels.value->size(); })
        .def("evaluate", &evaluate, "ram"_a, nb::arg("values").noconvert(), nb::arg("visible").noconvert(),
             nb::sig("def evaluate(self, ram: " NDARRAY("uint8") ", values: " NDARRAY("int32") ", visible: " NDARRAY(
                 "bool") ") -> None"),
             "Fill `values` and `visible`, (labels, rows), from `ram`, (rows, 128). Values that are not visible are 0.")
        .def(
            "byte_of",
            [](const Shared<Labels>& labels, int label, Ram ram, int value) {
                check(labels, label, ram);
                return labels.value->byte_of(static_cast<size_t>(label), ram.data(), value);
            },
            "label"_a, "ram"_a, "value"_a,
            nb::sig("def byte_of(self, label: int, ram: " NDARRAY("uint8") ", value: int) -> int"),
            "The byte that gives a label this value in this RAM, or -1.")
        .def("possible_values", &possible_values, "label"_a, "ram"_a,
             nb::sig("def possible_values(self, label: int, ram: " NDARRAY("uint8") ") -> list[int]"),
             "The values that a write can give a label in this RAM, in ascending order.");
}

}  // namespace atari
