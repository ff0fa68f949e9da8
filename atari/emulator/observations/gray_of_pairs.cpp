#include "gray_of_pairs.hpp"

#include <algorithm>
#include <vector>

#include "image.hpp"

namespace atari {
namespace {

std::vector<uint8_t> make(const Palette& palette) {
    std::vector<uint8_t> values;
    values.reserve(65536);
    for (const uint32_t early : palette.rgb)
        for (const uint32_t late : palette.rgb) {
            const auto channel = [&](int shift) { return std::max(early >> shift & 255, late >> shift & 255); };
            values.push_back(gray_of(channel(16), channel(8), channel(0)));
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
