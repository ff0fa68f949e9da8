#include "labels.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>
#include <utility>

#include "evaluate.hpp"

namespace atari {
namespace {

// The data that the program of a label reads.
struct LabelHost : PassiveHost {
    const uint8_t* ram;
    int32_t variables[Label::kVariables];

    uint8_t byte(int64_t address) const { return ram[address & (kRamSize - 1)]; }
};

int32_t run(const Program& program, const uint8_t* ram, uint8_t byte) {
    LabelHost host{{}, ram, {byte, 0}};
    evaluate(program, host);
    return host.variables[Label::kResult];
}

// Returns the program's result for each byte; empty if it reads more than the byte.
std::vector<int32_t> table_of(const Program& program) {
    std::vector<int32_t> table;
    for (int byte = 0; byte < 256 && !program.reads_ram(); ++byte)
        table.push_back(run(program, nullptr, static_cast<uint8_t>(byte)));
    return table;
}

int32_t result(const Program& program, const std::vector<int32_t>& table, const uint8_t* ram, int index) {
    return table.empty() ? run(program, ram, ram[index]) : table[ram[index]];
}

bool has_decimal_digits(int byte) { return (byte & 15) <= 9 && byte >> 4 <= 9; }

}  // namespace

void Label::check() const {
    if (index < 0 || index >= kRamSize) throw std::invalid_argument("the index of a label is within 0..127");
    if (mask < 0 || mask > 255) throw std::invalid_argument("the mask of a label is within 0..255");
}

Labels::Labels(std::vector<Label> labels) : labels_(std::move(labels)) {
    for (const Label& label : labels_) {
        label.check();
        tables_.push_back({table_of(label.value), table_of(label.visible)});
    }
}

int32_t Labels::value(size_t label, const uint8_t* ram) const {
    return result(labels_[label].value, tables_[label].value, ram, labels_[label].index);
}

bool Labels::visible(size_t label, const uint8_t* ram) const {
    const Label& which = labels_[label];
    return !which.hides || result(which.visible, tables_[label].visible, ram, which.index) != 0;
}

void Labels::evaluate(const uint8_t* ram, size_t rows, int32_t* values, uint8_t* visible) const {
    for (size_t label = 0; label < labels_.size(); ++label) {
        for (size_t row = 0; row < rows; ++row) {
            const uint8_t* const bytes = ram + kRamSize * row;
            const bool shown = this->visible(label, bytes);
            *visible++ = shown;
            *values++ = shown ? value(label, bytes) : 0;
        }
    }
}

void Labels::all_values(size_t label, const uint8_t* ram, int32_t* values, bool* writable) const {
    const auto& [index, mask, decimal, program, visible, hides] = labels_[label];
    uint8_t changed[kRamSize];
    std::copy_n(ram, kRamSize, changed);
    for (int byte = 0; byte < 256; ++byte) {
        changed[index] = static_cast<uint8_t>(byte);
        values[byte] = run(program, changed, changed[index]);
        writable[byte] = (byte & ~mask) == (ram[index] & ~mask) && (!decimal || has_decimal_digits(byte & mask));
    }
}

int Labels::byte_of(size_t label, const uint8_t* ram, int32_t value) const {
    const int now = ram[labels_[label].index];
    if (this->value(label, ram) == value) return now;
    int32_t values[256];
    bool writable[256];
    all_values(label, ram, values, writable);
    int best = -1;
    const auto changes = [&](int byte) { return std::popcount(static_cast<unsigned>(byte ^ now)); };
    for (int byte = 0; byte < 256; ++byte)
        if (writable[byte] && values[byte] == value && (best < 0 || changes(byte) < changes(best))) best = byte;
    return best;
}

}  // namespace atari
