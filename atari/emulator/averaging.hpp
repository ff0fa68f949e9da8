// ALE's colour averaging: the mixture of two successive pictures, as palette indices.
#pragma once

#include <cstddef>
#include <cstdint>

#include "palettes.hpp"

namespace atari {

// For each pixel the colour nearest to 77 % of the brighter and 23 % of the darker of the two.
void average_pictures(const uint8_t* current, const uint8_t* previous, size_t count, const Palette& palette, uint8_t* out);

}  // namespace atari
