// Labels: named bytes of RAM and the values that they have.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "program.hpp"

namespace atari {

inline constexpr int kRamSize = 128;

// One label. In its programs, addresses are 0..127, variable 0 is the byte, and variable 1 is the result.
struct Label {
    static constexpr int kVariables = 2, kByte = 0, kResult = 1;

    int index = 0;         // the byte's, 0..127
    int mask = 0xff;       // the bits of the byte that belong to the label; a write keeps the others
    bool decimal = false;  // binary-coded decimal: a write has no digit above 9
    Program value, visible;
    bool hides = true;  // false if it is always visible, whatever `visible` is

    // Throws std::invalid_argument if the index or the mask is out of range.
    void check() const;
};

// The labels of a game, or some of them. Immutable after construction.
class Labels {
  public:
    explicit Labels(std::vector<Label> labels);

    size_t size() const { return labels_.size(); }
    const Label& operator[](size_t label) const { return labels_[label]; }

    // Returns the value of a label in these 128 bytes of RAM.
    int32_t value(size_t label, const uint8_t* ram) const;
    bool visible(size_t label, const uint8_t* ram) const;
    // Writes the values of all labels in `rows` copies of RAM. Label l of row i goes to l * rows + i. The value of a
    // label that is not visible is 0.
    void evaluate(const uint8_t* ram, size_t rows, int32_t* values, uint8_t* visible) const;

    // Returns the byte that gives a label this value in this RAM, or -1 if no byte does. If several bytes do, the
    // fewest changed bits decide, then the lowest byte.
    int byte_of(size_t label, const uint8_t* ram, int32_t value) const;
    // Writes the label's value for each of the 256 bytes, and whether a write may write that byte.
    void all_values(size_t label, const uint8_t* ram, int32_t* values, bool* writable) const;

  private:
    // The results of a label's programs for each byte. A program that reads other bytes has no table: it is run.
    struct Tables {
        std::vector<int32_t> value, visible;
    };

    std::vector<Label> labels_;
    std::vector<Tables> tables_;
};

}  // namespace atari
