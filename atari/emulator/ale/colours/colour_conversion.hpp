// Converts palette indices to RGB or luminance.
#pragma once

#include <cstdint>

#include "palettes.hpp"
#include "fast/simd.hpp"

namespace atari {

// Converts a framebuffer of palette indices, rows x 160, to red, green and blue bytes, or to luminance bytes.
void to_rgb(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out, SimdLevel level = simd_level());
void to_gray(const uint8_t* framebuffer, int rows, const Palette& palette, uint8_t* out);

}  // namespace atari
