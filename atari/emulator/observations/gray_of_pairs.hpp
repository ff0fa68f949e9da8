// `gray_of_pairs`: for PixelFormat::kGrayOfRgb, the gray value of the maximum of two colours.
#pragma once

#include <cstdint>

#include "ale/colours/palettes.hpp"

namespace atari {

// Returns 65,536 values, by early palette index * 256 + late palette index, equal to those of OpenCV's RGB2GRAY.
const uint8_t* gray_of_pairs(const Palette& palette);

}  // namespace atari
