// ALE's colour averaging: the mixture of two successive framebuffers, as palette indices.
#pragma once

#include <cstddef>
#include <cstdint>

#include "palettes.hpp"

namespace atari {

// Writes for each pixel the palette index nearest to 77 % of the brighter and 23 % of the darker of the two colours.
void average_framebuffers(const uint8_t* current, const uint8_t* previous, size_t count, const Palette& palette,
                          uint8_t* out);

}  // namespace atari
