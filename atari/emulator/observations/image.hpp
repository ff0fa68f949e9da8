// Images of any size: `resize_image` and `rgb_to_gray`, equal to OpenCV in every byte.
//
// The wrappers use them, which take images of any environment. Frames of the emulator, whose rows have 160 pixels, have
// `Resizer` and `pool_gray`.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fast/simd.hpp"

namespace atari {

struct ImageSize {
    int rows, columns;
    bool operator==(const ImageSize&) const = default;
};

constexpr int kLongestSide = 32768;  // a side of an image, and its number of channels, in pixels or bytes

// Writes the image in another size, as OpenCV's INTER_AREA: the means of areas if no side grows, else a linear
// interpolation. A pixel has `channels` bytes, which are independent. The arrays have rows x columns x channels bytes.
void resize_image(const uint8_t* image, ImageSize from, int channels, ImageSize to, uint8_t* out);

// Writes the brightness of each pixel of red, green and blue, rows x columns x 3, as OpenCV's RGB2GRAY: rows x columns
// bytes. A `SimdLevel` other than the chosen one is for tests: the results are the same.
void rgb_to_gray(const uint8_t* rgb, size_t rows, size_t columns, uint8_t* out, SimdLevel level = simd_level());

// Returns OpenCV's brightness of a colour: the weights 0.299, 0.587 and 0.114 in units of 2**-15, with its rounding.
constexpr uint8_t gray_of(uint32_t red, uint32_t green, uint32_t blue) {
    return static_cast<uint8_t>((9798 * red + 19235 * green + 3735 * blue + (1 << 14)) >> 15);
}

}  // namespace atari
