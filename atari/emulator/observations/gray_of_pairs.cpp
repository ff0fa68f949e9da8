#include "gray_of_pairs.hpp"

#include <algorithm>
#include <vector>

namespace atari {
namespace {

std::vector<uint8_t> make(const Palette& palette) {
    std::vector<uint8_t> values;
    values.reserve(65536);
    for (const uint32_t early : palette.rgb)
        for (const uint32_t late : palette.rgb) {
            const auto channel = [&](int shift) { return std::max(early >> shift & 255, late >> shift & 255); };
            // OpenCV's weights 0.299, 0.587 and 0.114, in units of 2**-15, and its rounding.
            const uint32_t sum = 9798 * channel(16) + 19235 * channel(8) + 3735 * channel(0);
            values.push_back(static_cast<uint8_t>((sum + (1 << 14)) >> 15));
        }
    return values;
}

template <const Palette& palette>
const uint8_t* table() {
    static const std::vector<uint8_t> values = make(palette);
    return values.data();
}

}  // namespace

const uint8_t* gray_of_pairs(const Palette& palette) {
    if (&palette == &PAL) return table<PAL>();
    if (&palette == &SECAM) return table<SECAM>();
    return table<NTSC>();
}

}  // namespace atari
